// Free flights and visibility by the board.
//
// A flight ends where the opacity gathered from its start on reaches its random number, which is even in 0..1. A
// batch's numbers lie one in each of as many strata, dealt at random. A command of the board has one opacity: the least
// of its flights, sorted by their numbers. Its first hits are samples; from there the host walks on to each flight's
// end, and finds that of a surface by halving.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "light/transport/medium.h"

namespace gicube::samples {

struct Flight {
  Vec3 place, direction;  // anywhere; unit
  bool in_glass = false;
};

struct Hit {
  Vec3 place;
  double distance = 0;
  int tag = 0;
  Vec3 normal{};  // of a surface, out of it; zero in a medium
};

struct Segment {
  Vec3 from, to;
};

class Flights {
 public:
  // `step`: voxels between samples. Both must outlive it.
  Flights(Board& board, const Medium& medium, double step, std::uint64_t seed)
      : board_(board), medium_(medium), step_(step), seed_(seed) {}

  // Nothing for a flight that leaves the volume.
  std::vector<std::optional<Hit>> first_hits(std::span<const Flight> flights);
  // The share of light that passes, 0..1. What lies outside of the volume is clear; glass stops all.
  std::vector<double> transmittances(std::span<const Segment> segments);

  std::uint64_t rays() const { return rays_; }

 private:
  struct Line {
    std::size_t index = 0;  // of the flight
    Vec3 place, direction;
    double begin = 0, end = 0, length = 0;  // distances; of a step
    bool in_glass = false;
    double opacity = 0;  // at which it ends
    Vec3 at(double distance) const { return place + distance * direction; }
  };
  std::optional<Line> line_of(const Flight& flight, std::size_t index, double begin) const;
  Ticket send(std::span<const Line> lines, double opacity);
  std::optional<Hit> hit_of(const Line& line, const TracedRay& ray, double opacity) const;
  std::optional<Hit> surface_between(const Line& line, double before, double after) const;
  void leave_glass(std::vector<Line> lines, std::vector<std::optional<Hit>>& hits);

  Board& board_;
  const Medium& medium_;
  double step_;
  std::uint64_t seed_, batches_ = 0, rays_ = 0;
};

// Where a path goes on from a surface: a little off it, to the side of `direction`.
Vec3 off_surface(const Hit& hit, Vec3 direction);

}  // namespace gicube::samples

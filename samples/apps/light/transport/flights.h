// Free path segments and visibility, traced by the board.
//
// A segment ends where the opacity from its start reaches its random number, uniform in 0..1. The numbers of a batch
// are stratified, one in each stratum, and dealt to its segments at random. A command of the board has one opacity, so
// segments are sorted by their numbers, and a command has the least number of its segments. The board returns the
// sample of that first hit; from there the host marches on to each segment's own end, and locates a surface by
// bisection.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "light/transport/medium.h"

namespace gicube::samples {

struct Flight {
  Vec3 place, direction;  // the place may be outside of the volume; the direction has unit length
  bool in_glass = false;
};

struct Hit {
  Vec3 place;
  double distance = 0;
  int tag = 0;
  Vec3 normal{};  // outward normal of a surface; zero in a medium
};

struct Segment {
  Vec3 from, to;
};

class Flights {
 public:
  // `step`: voxels between samples. Both must outlive it.
  Flights(Board& board, const Medium& medium, double step, std::uint64_t seed)
      : board_(board), medium_(medium), step_(step), seed_(seed) {}

  // The end of each segment; nothing if it leaves the volume.
  std::vector<std::optional<Hit>> first_hits(std::span<const Flight> flights);
  // The share of light that passes, 0..1. Space outside of the volume is clear; glass stops all light.
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

// Where a path continues from a surface: a little off it, on the side of `direction`.
Vec3 off_surface(const Hit& hit, Vec3 direction);

}  // namespace gicube::samples

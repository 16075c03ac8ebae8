// Paths from the eye and from lights, many at a time: each round is one batch of flights by the board.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "light/transport/flights.h"
#include "light/transport/lights.h"

namespace gicube::samples {

struct Vertex {
  Vec3 place;
  Vec3 normal{};       // of a surface or an area light; zero in a medium, and of an eye or a light without area
  Vec3 direction{};    // in which the path came; unit
  int tag = -1;        // -1: an eye or a light
  bool sharp = false;  // no connection finds its directions
  bool distant = false;
  Rgb weight{};  // of a light's path power, of an eye's path the share of a radiance, before this vertex scatters
  // Densities of this vertex from the one before it on its path, and from the one behind it; per area, or per volume
  // over the extinction. The chances that flights get so far are left out: they weigh all ways to make one path alike.
  double forward = 0, backward = 0;
};

struct Path {
  std::vector<Vertex> vertices;
  Flight flight;       // from the last one
  double density = 0;  // of its direction, per solid angle; 0: sharp
  Rgb weight{};
  PathRandom random{0, 0};
  bool ended = false;
};

// Converts a direction's density at `from` to a density at `to`.
double density_at(double density, const Vertex& from, const Vertex& to);

class Paths {
 public:
  Paths(const Medium& medium, const Lights& lights, Flights& flights)
      : medium_(medium), lights_(lights), flights_(flights) {}

  // From a light, with its first vertex on it.
  Path from_light(PathRandom random) const;
  // Lets paths fly and scatter until each has left the volume, was absorbed or has scattered `max_scatterings` times.
  // Russian roulette ends those of little weight. Calls `seen` for each flight with the distance of its end, infinite
  // outside, before the vertex is there.
  void walk(std::span<Path> paths, int max_scatterings,
            const std::function<void(const Path&, double)>& seen = {}) const;

 private:
  const Medium& medium_;
  const Lights& lights_;
  Flights& flights_;
};

}  // namespace gicube::samples

// Paths from the eye and from lights, many at a time: each round is one batch of path segments, traced by the board.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "light/transport/eye.h"
#include "light/transport/flights.h"
#include "light/transport/lights.h"

namespace gicube::samples {

struct Vertex {
  Vec3 place;
  Vec3 normal{};       // of a surface or an area light; zero in a medium, at an eye and at a light without area
  Vec3 direction{};    // unit vector along which the path arrived
  int tag = -1;        // -1: an eye or a light
  bool sharp = false;  // scatters into one direction, which no connection can have
  bool distant = false;
  // Before this vertex scatters: on a path from a light its power, on a path from the eye the share of a radiance.
  Rgb weight{};
  // Densities of this vertex, sampled from the vertex before it on its path and from the one after it; per area, or per
  // volume over the extinction. They omit the free-flight probabilities, which all strategies for a path share.
  double forward = 0, backward = 0;
};

struct Path {
  std::vector<Vertex> vertices;
  Flight flight;       // from the last vertex
  double density = 0;  // of its direction, per solid angle; 0: sharp
  Rgb weight{};
  PathRandom random{0, 0};
  bool ended = false;
};

// Converts a direction's density at `from` to a density at `to`.
double density_at(double density, const Vertex& from, const Vertex& to);
// Where a ray from the vertex along `direction` begins: a little off a surface.
Vec3 beside(const Vertex& vertex, Vec3 direction);
// A path from the eye through a random point of a pixel (rows from the top). Its density is over all the image's paths.
Path from_eye(const Eye& eye, std::size_t pixel, PathRandom random);

class Paths {
 public:
  Paths(const Medium& medium, const Lights& lights, Flights& flights)
      : medium_(medium), lights_(lights), flights_(flights) {}

  // A path whose first vertex is on a light.
  Path from_light(PathRandom random) const;
  // Extends the paths until each has left the volume, was absorbed or has scattered `max_scatterings` times. Russian
  // roulette ends paths of little weight. Calls `seen` for each segment, before its end becomes a vertex, with the
  // distance of the end; infinite if the path leaves the volume.
  void walk(std::span<Path> paths, int max_scatterings,
            const std::function<void(const Path&, double)>& seen = {}) const;

 private:
  const Medium& medium_;
  const Lights& lights_;
  Flights& flights_;
};

}  // namespace gicube::samples

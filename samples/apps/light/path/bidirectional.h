// Bidirectional path tracing in a volume (Veach 1997; in media Lafortune and Willems 1996): every vertex of each path
// from the eye is connected with every vertex of a path from a light, and the strategies that can make a path are
// weighted by the balance heuristic. The board traces the segments of paths, and tests the connections.
#pragma once

#include <cstdint>
#include <vector>

#include "light/transport/eye.h"
#include "light/transport/paths.h"
#include "light/transport/radiance.h"

namespace gicube::samples {

struct BidirectionalSettings {
  int light_scatterings = 3;  // of a path from a light; 0: no such paths, only connections of the eye's with a light
  int max_scatterings = 32;   // of a whole path: light that was scattered more often is missing
  double step = 0.5;          // voxels between the board's samples
  std::uint64_t seed = 0;
};

struct PathStatistics {
  std::uint64_t paths = 0;        // from the eye
  std::uint64_t connections = 0;  // for which visibility rays were sent
  std::uint64_t rays = 0;         // of all kinds, traced by the board
};

class Bidirectional {
 public:
  // The arguments must outlive it. Throws InputError as Eye().
  Bidirectional(Board& board, const Medium& medium, const Lights& lights, const View& view,
                const BidirectionalSettings& settings);

  // One more path for each pixel.
  void pass();
  RadiancePicture picture() const { return sum_.picture(); }
  const PathStatistics& statistics() const { return statistics_; }

 private:
  struct Connection {
    Segment segment;
    std::size_t pixel = 0;
    Rgb value;
  };
  void trace(std::size_t first, std::size_t count, std::vector<Rgb>& pixels);
  void see(const Path& eye, std::size_t pixel, double reach, std::vector<Rgb>& pixels) const;
  void connect_with_light(const Path& eye, std::size_t t, std::size_t pixel, PathRandom& random,
                          std::vector<Connection>& out) const;
  void connect(const Path& eye, std::size_t t, const Path& light, std::size_t s, std::size_t pixel,
               std::vector<Connection>& out) const;
  Rgb scattered(const Vertex& vertex, Vec3 out) const;  // its weight times the share that it scatters along `out`
  double density_of(const Vertex& at, Vec3 came, Vec3 goes) const;

  // A vertex of a whole path from a light to the eye, with its densities from both sides.
  struct Node {
    double from_light = 0, from_eye = 0;
    bool sharp = false;
  };
  double balance(const std::vector<Node>& nodes, std::size_t s, bool area_light) const;

  const Medium& medium_;
  const Lights& lights_;
  Eye eye_;
  BidirectionalSettings settings_;
  Flights flights_;
  Paths paths_;
  RadianceSum sum_;
  PathStatistics statistics_;
};

}  // namespace gicube::samples

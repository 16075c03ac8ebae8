// A triangle mesh in memory, and a closed one with what the sign of a distance needs: one pseudonormal a face, an edge and a point.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "gicube/vector.h"

namespace gicube::samples {

struct Mesh {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices of points, counter-clockwise as seen from outside
};

struct SurfaceTriangle {
  std::array<Vec3, 3> corners;
  Vec3 normal;                         // unit
  std::array<Vec3, 3> edge_normals;    // of the edges 0-1, 1-2, 2-0: the sum of both faces' normals
  std::array<Vec3, 3> corner_normals;  // sums of the faces' normals by their angle there
};

// All triangles with an area. Throws InputError as MeshDistance does.
std::vector<SurfaceTriangle> closed_surface(const Mesh& mesh, const std::string& name);

}  // namespace gicube::samples

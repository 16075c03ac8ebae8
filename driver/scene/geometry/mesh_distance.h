// The signed distance of a closed triangle mesh: the nearest triangle by a tree of boxes, the sign by the
// angle-weighted pseudonormal of the nearest corner, edge or face (J. A. Baerentzen and H. Aanaes, Signed Distance
// Computation Using the Angle Weighted Pseudonormal, IEEE TVCG 11(3), 2005).
#pragma once

#include <string>
#include <vector>

#include "gicube/scene/mesh.h"
#include "scene/geometry/signed_distance.h"

namespace gicube::scene {

// A triangle of a closed surface that has an area.
struct SurfaceTriangle {
  std::array<Vec3, 3> corners;
  Vec3 normal;                         // unit
  std::array<Vec3, 3> edge_normals;    // of the edges 0-1, 1-2, 2-0: the sum of both faces' normals
  std::array<Vec3, 3> corner_normals;  // sums of the faces' normals by their angle there
};

// The triangles of a mesh. Throws InputError like MeshDistance.
std::vector<SurfaceTriangle> closed_surface(const Mesh& mesh, const std::string& name);

class MeshDistance {
 public:
  // Points at the same position are merged; triangles without area keep the surface closed but have no inside. A mesh
  // whose triangles all face inwards is inverted. Throws InputError with `name`: no triangles, an index beyond the
  // points, coordinates above 1e9 or not finite, an edge without exactly two triangles (the surface is open or
  // branches), neighbouring triangles that face opposite sides, no volume.
  MeshDistance(const Mesh& mesh, const std::string& name);
  Distance at(Vec3 p) const;

 private:
  struct Bounds {
    Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};

    void add(Vec3 p);
    double squared_distance(Vec3 p) const;
  };
  struct Box {
    Bounds bounds;
    std::uint32_t first = 0;  // triangle of a leaf, or else the first of two boxes
    std::uint32_t count = 0;  // triangles; 0 = two boxes
  };

  void build(std::size_t index, std::uint32_t first, std::uint32_t last);

  std::vector<SurfaceTriangle> surface_;
  std::vector<Box> boxes_;
};

}  // namespace gicube::scene

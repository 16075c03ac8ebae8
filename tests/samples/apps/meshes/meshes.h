// Meshes of a few triangles.
#pragma once

#include "gicube/scene/mesh.h"

namespace gicube::samples {

// A square of edges 2 `half` across z, at z, normal +z.
inline scene::Mesh square(double half, double z) {
  return {{{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}}, {{0, 1, 2}, {0, 2, 3}}};
}

// A closed cube around the origin, its faces outwards.
inline scene::Mesh cube(double half) {
  scene::Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.points.push_back({(i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, (i & 4) != 0 ? half : -half});
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

}  // namespace gicube::samples

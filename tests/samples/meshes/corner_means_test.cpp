// Values of triangles that are smooth over a mesh, but not over its edges.
#include "meshes/corner_means.h"

#include <gtest/gtest.h>

#include "meshes/triangulate.h"

namespace gicube::samples {
namespace {

TEST(CornerMeans, AreTheValuesOfAConstantAndStopAtEdges) {
  const Mesh mesh = refined(mesh_of(BoxShape{{0, 0, 0}, {2, 2, 2}}), 1);
  std::vector<TriangleValue> values;
  for (const auto& [a, b, c] : mesh.triangles) {
    const bool top = mesh.points[a].z == 2 && mesh.points[b].z == 2 && mesh.points[c].z == 2;
    values.push_back({top ? 1.0 : 0.0, 3, 0});
  }
  const auto means = corner_means(mesh, values);
  for (std::size_t t = 0; t < values.size(); ++t) {
    const Vec3 place = mesh.points[mesh.triangles[t][1]];
    const TriangleValue there = between_corners(mesh, t, means[t], place);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(there[c], values[t][c], 1e-12);
  }
}

TEST(CornerMeans, AreLinearBetweenCorners) {
  const Mesh mesh{{{0, 0, 0}, {2, 0, 0}, {0, 4, 0}}, {{0, 1, 2}}};
  const std::array<TriangleValue, 3> corners{{{0, 0, 0}, {4, 0, 1}, {8, 8, 2}}};
  const TriangleValue there = between_corners(mesh, 0, corners, {0.5, 2, 0});
  EXPECT_NEAR(there[0], 0.25 * 4 + 0.5 * 8, 1e-12);
  EXPECT_NEAR(there[1], 4, 1e-12);
  EXPECT_NEAR(there[2], 1.25, 1e-12);
}

}  // namespace
}  // namespace gicube::samples

// Triangles of boxes, and finer ones: the same surface.
#include "meshes/triangulate.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace gicube::samples {
namespace {

double area(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    sum += 0.5 * length(cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]));
  return sum;
}

// Six times the volume, by Gauss's theorem: positive if triangles face outwards.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) sum += dot(mesh.points[a], cross(mesh.points[b], mesh.points[c])) / 6;
  return sum;
}

TEST(Triangulate, ABoxHasItsAreaAndVolume) {
  const Mesh mesh = mesh_of(BoxShape{{1, 2, 3}, {2, 4, 6}});
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_NEAR(area(mesh), 2 * (2 + 3 + 6), 1e-12);
  EXPECT_NEAR(volume(mesh), 6, 1e-12);
}

TEST(Triangulate, FinerTrianglesAreTheSameSurfaceWithoutGaps) {
  const Mesh box = mesh_of(BoxShape{{0, 0, 0}, {4, 4, 4}});
  const Mesh mesh = refined(box, 1.5);
  EXPECT_NEAR(area(mesh), area(box), 1e-12);
  EXPECT_NEAR(volume(mesh), volume(box), 1e-12);
  double longest = 0;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, length(mesh.points[t[i]] - mesh.points[t[(i + 1) % 3]]));
  }
  EXPECT_LE(longest, 1.5);
  EXPECT_EQ(mesh.triangles.size(), 12u * 16);
  EXPECT_EQ(mesh.points.size(), 6u * 25);  // neighbours share their corners
  EXPECT_EQ(refined(box, 100).triangles, box.triangles);
}

}  // namespace
}  // namespace gicube::samples

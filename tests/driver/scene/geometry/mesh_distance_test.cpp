#include "scene/geometry/mesh_distance.h"

#include "gicube/scene/error.h"
#include "test.h"
#include "test_meshes.h"

namespace gicube::scene {
namespace {

std::string fault_of(const Mesh& mesh) {
  return message_of<InputError>([&] { MeshDistance(mesh, "a.obj"); });
}

TEST(MeshDistance, IsThatOfTheBoxForACube) {
  const MeshDistance mesh(cube_mesh(), "cube");
  std::mt19937 random(3);
  std::uniform_real_distribution<double> side(-2, 2);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p{side(random), side(random), side(random)};
    const Distance expected = box_distance(p, {-1, -1, -1}, {1, 1, 1}, 0), got = mesh.at(p);
    ASSERT_NEAR(got.distance, expected.distance, 1e-12) << p.x << ' ' << p.y << ' ' << p.z;
    if (expected.distance > 1e-3) {
      ASSERT_LT(length(got.away - expected.away), 1e-9);
    }
  }
}

// A facet of 5120 lies at most 0.2% of the radius within the sphere.
TEST(MeshDistance, IsNearlyThatOfTheSphereForAFineIcosphere) {
  const MeshDistance mesh(sphere_mesh(4), "sphere");
  std::mt19937 random(4);
  std::uniform_real_distribution<double> side(-1.5, 1.5);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p{side(random), side(random), side(random)};
    const Distance got = mesh.at(p);
    ASSERT_NEAR(got.distance, length(p) - 1, 0.003);
    if (std::abs(got.distance) > 0.1 && length(p) > 0.3) {
      ASSERT_LT(length(got.away - normalise(p)), 0.1);
    }
  }
}

// Where the nearest place is a corner or an edge, the normal of one face alone gives the wrong side.
TEST(MeshDistance, KnowsInsideFromOutsideNearSharpCornersAndEdges) {
  Mesh spike;  // a long thin pyramid
  spike.points = {{0, 0, 10}, {0.1, 0, 0}, {-0.1, 0.1, 0}, {-0.1, -0.1, 0}};
  spike.triangles = {{1, 3, 2}, {0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
  const MeshDistance mesh(spike, "spike");
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Vec3 around{normal(random), normal(random), std::abs(normal(random))};
    EXPECT_GT(mesh.at(Vec3{0, 0, 10} + 0.5 * around).distance, 0);
  }
  EXPECT_LT(mesh.at({0, 0, 1}).distance, 0);
  EXPECT_LT(mesh.at({-0.02, 0, 5}).distance, 0);
}

TEST(MeshDistance, TurnsAMeshThatLooksInwardsInsideOut) {
  Mesh mesh = cube_mesh();
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_LT(MeshDistance(mesh, "cube").at({}).distance, 0);
}

TEST(MeshDistance, WeldsPointsAtTheSamePlaceAndIgnoresTrianglesWithoutArea) {
  Mesh soup;
  for (const auto& triangle : cube_mesh().triangles) {
    for (const std::uint32_t corner : triangle) soup.points.push_back(cube_mesh().points[corner]);
    const auto n = static_cast<std::uint32_t>(soup.points.size());
    soup.triangles.push_back({n - 3, n - 2, n - 1});
    soup.triangles.push_back({n - 3, n - 3, n - 1});
  }
  EXPECT_NEAR(MeshDistance(soup, "soup").at({0.5, 0, 0}).distance, -0.5, 1e-12);
}

TEST(MeshDistance, RefusesWhatHasNoInside) {
  Mesh open = cube_mesh();
  open.triangles.pop_back();
  EXPECT_THAT(fault_of(open), HasSubstr("a.obj: expected a closed surface"));
  EXPECT_THAT(fault_of(open), HasSubstr("got 3 open edges"));
  Mesh turned = cube_mesh();
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  EXPECT_THAT(fault_of(turned), HasSubstr("opposite sides"));
  Mesh flat;
  flat.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_THAT(fault_of(flat), HasSubstr("a volume inside"));
  EXPECT_THAT(fault_of({}), HasSubstr("triangles"));
  Mesh far = cube_mesh();
  far.points[0].x = 1e300;
  EXPECT_THAT(fault_of(far), HasSubstr("coordinates up to"));
  far.points[0].x = std::nan("");
  EXPECT_THAT(fault_of(far), HasSubstr("coordinates up to"));
  Mesh beyond = cube_mesh();
  beyond.triangles[0][0] = 8;
  EXPECT_THAT(fault_of(beyond), HasSubstr("points from 0 to"));
}

}  // namespace
}  // namespace gicube::scene

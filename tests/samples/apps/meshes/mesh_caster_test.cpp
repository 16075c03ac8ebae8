#include "meshes/mesh_caster.h"

#include "meshes.h"
#include "test.h"

namespace gicube::samples {
namespace {

std::vector<Crossing> crossings(const MeshCaster& caster, Vec3 from, Vec3 direction) {
  std::vector<Crossing> found;
  caster.find(from, normalise(direction), found);
  return found;
}

TEST(MeshCaster, FindsAllCrossingsInOrder) {
  const MeshCaster caster({square(1, 3), square(1, 1), square(1, 2)});
  const auto found = crossings(caster, {0.2, 0.1, 0}, {0, 0, 1});
  ASSERT_EQ(found.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(found[i].mesh, (std::array{1u, 2u, 0u})[i]);
    EXPECT_NEAR(found[i].distance, static_cast<double>(i) + 1, 1e-15);
    EXPECT_FALSE(found[i].from_outside);
    EXPECT_EQ(caster.normal(found[i]), (Vec3{0, 0, 1}));
  }
  EXPECT_TRUE(crossings(caster, {0.2, 0.1, 4}, {0, 0, -1}).at(0).from_outside);
  EXPECT_EQ(crossings(caster, {0.2, 0.1, 2.5}, {0, 0, 1}).size(), 1u);  // the others are behind
}

TEST(MeshCaster, CrossesASurfaceOnceAtACommonEdgeOrCorner) {
  const MeshCaster caster({cube(1)});
  for (const Vec3 through : {Vec3{0, 0, 0}, {0.5, 0.5, 0}, {1e-9, 0, 0}, {-0.25, -0.25, 0}}) {
    EXPECT_EQ(crossings(caster, through - Vec3{0, 0, 5}, {0, 0, 1}).size(), 2u);  // on the faces' diagonals
  }
  EXPECT_EQ(crossings(caster, {-5, -5, -5}, {1, 1, 1}).size(), 2u);  // from corner to corner
}

TEST(MeshCaster, EntersAndLeavesAClosedSurfaceByTurns) {
  const MeshCaster caster({cube(1)});
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> place(-2, 2);
  int met = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 from{place(engine), place(engine), -4}, to{place(engine), place(engine), 4};
    const auto found = crossings(caster, from, to - from);
    ASSERT_EQ(found.size() % 2, 0u);
    met += found.empty() ? 0 : 1;
    for (std::size_t k = 0; k < found.size(); ++k) {
      ASSERT_EQ(found[k].from_outside, k % 2 == 0);
      const Vec3 at = from + found[k].distance * normalise(to - from);
      ASSERT_NEAR(std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)}), 1, 1e-6);
    }
  }
  EXPECT_GT(met, 5000);
}

TEST(MeshCaster, MeetsNothingWithoutMeshesAndNoTriangleWithoutArea) {
  EXPECT_TRUE(crossings(MeshCaster({}), {0, 0, 0}, {0, 0, 1}).empty());
  const Mesh line{{{0, 0, 1}, {1, 0, 1}, {2, 0, 1}}, {{0, 1, 2}}};
  EXPECT_TRUE(crossings(MeshCaster({line}), {1, 0, 0}, {0, 0, 1}).empty());
}

}  // namespace
}  // namespace gicube::samples

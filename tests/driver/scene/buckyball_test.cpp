#include "scene/buckyball.h"

#include "gicube/scene/error.h"
#include "scene/geometry/signed_distance.h"
#include "test.h"

namespace gicube::scene {
namespace {

constexpr int kSize = 64;

int density(const VoxelWorld& ball, int x, int y, int z) {
  const int size = ball.volume.dims[0];
  std::uint16_t value = 0;
  std::memcpy(&value, &ball.volume.samples[2 * static_cast<std::size_t>((z * size + y) * size + x)], sizeof value);
  return value;
}

std::size_t index(int x, int y, int z) { return static_cast<std::size_t>((z * kSize + y) * kSize + x); }

// Where an atom or a bond's point stands, to the nearest voxel; by a way of its own from the shape's numbers.
Dims voxel_of(Vec3 on_unit_sphere) {
  const BuckyballShape shape;
  const double turn = shape.turn_degrees * std::numbers::pi / 180;
  const Vec3 turned{std::cos(turn) * on_unit_sphere.x - std::sin(turn) * on_unit_sphere.y,
                    std::sin(turn) * on_unit_sphere.x + std::cos(turn) * on_unit_sphere.y, on_unit_sphere.z};
  const Vec3 p = (kSize - 1.0) * (shape.centre + shape.circumradius * turned);
  return {static_cast<int>(std::lround(p.x)), static_cast<int>(std::lround(p.y)), static_cast<int>(std::lround(p.z))};
}

TEST(Buckyball, IsDenseAtEveryAtomsCentreAndTaggedAtom) {
  const VoxelWorld ball = make_buckyball(kSize, false);
  for (const Vec3& atom : truncated_icosahedron().atoms) {
    const auto [x, y, z] = voxel_of(atom);
    EXPECT_EQ(density(ball, x, y, z), 4095);
    EXPECT_EQ(ball.tags[index(x, y, z)], kAtom);
  }
}

TEST(Buckyball, IsDenseInTheMiddleOfEveryBondAndTaggedBond) {
  const VoxelWorld ball = make_buckyball(kSize, false);
  const Molecule molecule = truncated_icosahedron();
  for (const auto& [from, to] : molecule.bonds) {
    const auto [x, y, z] =
        voxel_of(0.5 * (molecule.atoms[static_cast<std::size_t>(from)] + molecule.atoms[static_cast<std::size_t>(to)]));
    EXPECT_GT(density(ball, x, y, z), 4095 / 2);
    EXPECT_EQ(ball.tags[index(x, y, z)], kBond);
  }
}

TEST(Buckyball, IsEmptyInItsMiddleAndAboveIt) {
  const VoxelWorld ball = make_buckyball(kSize, false);
  const auto [x, y, z] = voxel_of({0, 0, 0});
  EXPECT_EQ(density(ball, x, y, z), 0);
  for (int i = 0; i < kSize; ++i) EXPECT_EQ(density(ball, i, i, kSize - 1), 0);
}

TEST(Buckyball, StandsAboveATiledFloorWithAGapBetween) {
  const VoxelWorld ball = make_buckyball(kSize, false);
  const int middle = kSize / 2;
  const int floor_z = static_cast<int>(std::lround(0.0525 * (kSize - 1)));
  EXPECT_EQ(density(ball, middle, middle, floor_z), 4095);
  EXPECT_EQ(density(ball, middle, middle, static_cast<int>(0.11 * (kSize - 1))), 0);
  EXPECT_NE(ball.tags[index(middle - 3, middle - 3, floor_z)], ball.tags[index(middle - 3, middle + 3, floor_z)]);
  EXPECT_GE(ball.tags[index(middle, middle, floor_z)], kFloor);
}

TEST(Buckyball, RisesLinearlyOverTwoVoxelsAcrossTheFloorsSurface) {
  const VoxelWorld ball = make_buckyball(kSize, false);
  const double top = BuckyballShape{}.floor_high.z * (kSize - 1);
  for (int z = static_cast<int>(top) - 1; z <= static_cast<int>(top) + 2; ++z) {
    const double expected = 4095 * std::clamp(0.5 - (z - top) / 2, 0.0, 1.0);
    EXPECT_NEAR(density(ball, kSize / 2, kSize / 2, z), expected, 0.5) << "z " << z;
  }
}

TEST(Buckyball, GivesUnitNormalsThatPointInwardsNearTheSurfaceAndNoneFarAway) {
  const VoxelWorld ball = make_buckyball(kSize, true);
  const std::size_t top = index(kSize / 2, kSize / 2, 5);  // the floor's top is at 4.7
  EXPECT_FLOAT_EQ(ball.gradients[3 * top + 2], -1);
  const auto [x, y, z] = voxel_of({0, 0, 0});
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(ball.gradients[3 * index(x, y, z) + i], 0);
  for (std::size_t i = 0; i < ball.tags.size(); ++i) {
    const float* g = &ball.gradients[3 * i];
    const double norm = std::hypot(g[0], g[1], g[2]);
    ASSERT_TRUE(norm == 0 || std::abs(norm - 1) < 1e-5) << "voxel " << i;
    std::uint16_t value = 0;
    std::memcpy(&value, &ball.volume.samples[2 * i], sizeof value);
    if (value > 0 && value < 4095) {
      ASSERT_GT(norm, 0) << "voxel " << i;
    }
  }
}

TEST(Buckyball, IsTheSameForAnyNumberOfThreads) {
  const VoxelWorld one = make_buckyball(45, true, 1), many = make_buckyball(45, true, 5);
  EXPECT_EQ(one.volume.samples, many.volume.samples);
  EXPECT_EQ(one.tags, many.tags);
  EXPECT_EQ(one.gradients, many.gradients);
}

TEST(Buckyball, RefusesASizeOutOfRange) {
  EXPECT_THROW(make_buckyball(kMinBuckyballSize - 1, false), InputError);
  EXPECT_THROW(make_buckyball(kMaxBuckyballSize + 1, false), InputError);
}

TEST(Buckyball, BringsOneTransferFunctionATag) {
  const Appearance look = buckyball_appearance(kSize);
  ASSERT_EQ(look.materials.size(), 4u);
  for (const TransferFunctionFile& material : look.materials) {
    EXPECT_EQ(material.function.opacities.front().opacity, 0);
    EXPECT_EQ(material.function.opacities.back().opacity, 1);
  }
}

TEST(SignedDistance, HasTheGradientOfTheBoxByCentralDifferences) {
  const Vec3 low{1, 2, 3}, high{9, 7, 5};
  const double h = 1e-6;
  for (const Vec3 p : {Vec3{0.2, 4, 4}, Vec3{9.5, 8, 6}, Vec3{5, 6.6, 4.1}, Vec3{1.1, 2.2, 3.05}, Vec3{5, 4.5, 8}}) {
    const auto at = [&](Vec3 q) { return box_distance(q, low, high, 0.3).distance; };
    const Vec3 away = box_distance(p, low, high, 0.3).away;
    EXPECT_NEAR(away.x, (at(p + Vec3{h, 0, 0}) - at(p - Vec3{h, 0, 0})) / (2 * h), 1e-5);
    EXPECT_NEAR(away.y, (at(p + Vec3{0, h, 0}) - at(p - Vec3{0, h, 0})) / (2 * h), 1e-5);
    EXPECT_NEAR(away.z, (at(p + Vec3{0, 0, h}) - at(p - Vec3{0, 0, h})) / (2 * h), 1e-5);
  }
}

}  // namespace
}  // namespace gicube::scene

// Form factors of pairs that touch, overlap, hide each other or have no extent.
#include "form_factors/exchange/box_factor.h"
#include "stability.h"
#include "test.h"

namespace gicube::stability {
namespace {

constexpr int kSize = 40;
constexpr double kSide = 20;                                                                // voxels
const Element kFloor{ElementKind::kPatch, {5, 5, 5}, {kSide, 0, 0}, {0, kSide, 0}, {}};     // looks up
const Element kCeiling{ElementKind::kPatch, {5, 5, 25}, {0, kSide, 0}, {kSide, 0, 0}, {}};  // looks down
const Element kWall{ElementKind::kPatch, {5, 5, 5}, {0, kSide, 0}, {0, 0, kSide}, {}};      // looks along +x

Element cube(double x) { return {ElementKind::kBox, {10 + x, 10, 10}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}; }

class StabilityOfFormFactors : public testing::Test {
 protected:
  void SetUp() override { load_fog(board_, {kSize, kSize, kSize}, 0); }
  PairFactor factor(const Element& a, const Element& b, std::uint32_t rays) {
    return board_.pair_factors(std::array{a, b}, std::array{ElementPair{0, 1, 7}}, {.rays = rays})[0];
  }

  Board board_ = Board::open(small_board());
};

// 1/r^2 has no bound at the common edge; the parts that the driver divides them into have.
TEST_F(StabilityOfFormFactors, SquaresThatTouchAreRightWithFewRays) {
  constexpr double kExpected = 0.200044;  // perpendicular, common edge
  for (const std::uint32_t rays : {1u, 16u, 4096u}) {
    const PairFactor found = factor(kFloor, kWall, rays);
    const double value = found.transported * kSide * kSide, error = found.standard_error * kSide * kSide;
    EXPECT_NEAR(value, kExpected, 0.005 * kExpected) << rays;
    EXPECT_NEAR(value, kExpected, 3 * error) << rays;
    if (rays == 4096) record("touching_squares_error_of_4096_rays", value / kExpected - 1);
  }
}

TEST_F(StabilityOfFormFactors, VoxelsThatTouchOrOverlapHaveABoundedMean) {
  const auto box = [](double x) { return samples::AxisBox{{x, 0, 0}, {x + 1, 1, 1}, samples::kMedium}; };
  for (const double apart : {0.0, 0.5, 1.0}) {  // the same voxel; half of it; next to it
    const PairFactor found = factor(cube(0), cube(apart), 65'536);
    const double expected = samples::WayFactor(box(0), box(apart)).at(0);
    EXPECT_NEAR(found.transported, expected, 0.005 * expected) << apart;
    EXPECT_NEAR(found.transported, expected, 3 * found.standard_error) << apart;
    EXPECT_TRUE(std::isfinite(factor(cube(0), cube(apart), 64).transported));
    // Centre to centre would be 1 where they touch, and infinite where they are the same.
    if (apart == 1) record("mean_of_1_over_r2_of_voxels_that_touch", found.transported * std::numbers::pi);
    if (apart == 0) record("mean_of_1_over_r2_within_a_voxel", found.transported * std::numbers::pi);
  }
  EXPECT_NEAR(factor(cube(0), cube(1), 65'536).transported * std::numbers::pi, 1.196, 0.005 * 1.196);
}

TEST_F(StabilityOfFormFactors, APairThatIsHiddenOrTurnedAwayHasNone) {
  EXPECT_GT(factor(kFloor, kCeiling, 1024).transported, 0);
  std::vector<std::byte> wall(std::size_t{kSize} * kSize * kSize, std::byte{0});
  for (std::size_t i = 0; i < wall.size(); ++i) {
    const std::size_t z = i / kSize / kSize;
    if (z == 14 || z == 15 || z == 16) wall[i] = std::byte{200};
  }
  board_.load_volume({.samples = wall, .dims = {kSize, kSize, kSize}});
  board_.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{100, 0}, {100, 1}}});
  const PairFactor hidden = factor(kFloor, kCeiling, 1024);
  EXPECT_EQ(hidden.transported, 0);
  EXPECT_GT(hidden.geometric, 0);
  EXPECT_FALSE(hidden.clear);
  const Element away{ElementKind::kPatch, {5, 5, 25}, {kSide, 0, 0}, {0, kSide, 0}, {}};
  EXPECT_EQ(factor(kFloor, away, 64).geometric, 0);
  EXPECT_EQ(factor(kFloor, kFloor, 64).geometric, 0);  // a flat patch does not see itself
}

TEST_F(StabilityOfFormFactors, AnElementWithoutExtentGivesNothing) {
  const Element line{ElementKind::kPatch, {5, 5, 15}, {4, 0, 0}, {8, 0, 0}, {}};
  const Element point{ElementKind::kBox, {9, 9, 9}, {}, {}, {}};
  EXPECT_EQ(factor(kFloor, line, 64).transported, 0);
  EXPECT_EQ(factor(point, point, 64).transported, 0);  // not infinite
}

}  // namespace
}  // namespace gicube::stability

// What the empty flags prove of pairs of elements, against points on many rays between them.
#include "encode/pairs.h"

#include "test.h"

namespace gicube {
namespace {

constexpr int kBlock = 8;
constexpr int kSize = 64;
const Dims kBlocks{8, 8, 8};

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  float operator()(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine_); }

  // Anywhere in the volume, of up to `edge` voxels; one in two on voxel faces, as elements of radiosity are.
  wire::Element element(float edge) {
    const bool box = (*this)(0, 1) < 0.5F, on_grid = (*this)(0, 1) < 0.5F;
    wire::Element made{box ? wire::ElementKind::kBox : wire::ElementKind::kPatch, {}, {}, {}, {}};
    for (std::size_t axis = 0; axis < 3; ++axis) made.origin[axis] = (*this)(0, kSize - 1 - edge);
    if (on_grid) {
      for (float& x : made.origin) x = std::floor(x);
    }
    made.u[0] = on_grid ? edge : (*this)(0, edge);
    made.v[1] = on_grid ? edge : (*this)(0, edge);
    if (box) made.w[2] = edge;
    if (!on_grid) made.v[2] = (*this)(0, box ? 0 : edge);
    return made;
  }

 private:
  std::mt19937 engine_;
};

std::size_t block_of(const wire::Vector& at) {
  const auto of = [](double x) { return static_cast<std::size_t>(std::floor(x / kBlock)); };
  return of(at[0]) + 8 * (of(at[1]) + 8 * of(at[2]));
}

// Whether points on 200 of the rays between the two, eight a voxel, are all in empty blocks.
bool looks_clear(const wire::Element& a, const wire::Element& b, const std::vector<std::uint8_t>& flags) {
  for (std::uint32_t ray = 0; ray < 200; ++ray) {
    const auto sample = wire::pair_sample(a, b, {}, {1, 1, 1}, 7, 1, ray);
    for (int i = 0; i <= 8 * kSize; ++i) {
      wire::Vector at{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        at[axis] = std::lerp(sample.from[axis], sample.to[axis], i / (8.0 * kSize));
      }
      if (flags[block_of(at)] == 0) return false;
    }
  }
  return true;
}

TEST(ClearPaths, AreProvedOnlyWhereEveryPointOfEveryRayLiesInAnEmptyBlockAndMostlyThen) {
  Draw draw(3);
  int proved = 0, seen = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<std::uint8_t> flags(512);
    for (auto& flag : flags) flag = draw(0, 1) < 0.9F;
    const auto a = draw.element(2), b = draw.element(2);
    const bool clear = is_clear(a, b, {kBlocks, kBlock, flags}, 0.5);
    const bool looks = looks_clear(a, b, flags);
    ASSERT_TRUE(looks || !clear) << round;
    EXPECT_EQ(is_clear(b, a, {kBlocks, kBlock, flags}, 0.5), clear);
    proved += clear ? 1 : 0, seen += looks ? 1 : 0;
  }
  EXPECT_GT(proved, 500);
  EXPECT_GT(proved, 0.6 * seen);
}

wire::Element cube(float x, float y, float z) {
  return {wire::ElementKind::kBox, {x, y, z}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

TEST(ClearPaths, ARayInABlocksFaceNeedsTheBlocksOfBothSides) {
  std::vector<std::uint8_t> flags(512, 1);
  const auto a = cube(2, 8, 2), b = cube(60, 8, 2);  // their lower y faces lie in the face between two rows of blocks
  EXPECT_TRUE(is_clear(a, b, {kBlocks, kBlock, flags}, 0.5));
  flags[3] = 0;
  EXPECT_FALSE(is_clear(a, b, {kBlocks, kBlock, flags}, 0.5));
  EXPECT_TRUE(is_clear(cube(2, 8.5F, 2), cube(60, 8.5F, 2), {kBlocks, kBlock, flags}, 0.5));
  // Thin steps stray further from the straight way: 3714 roundings of 1/16384 voxel.
  EXPECT_TRUE(is_clear(cube(2, 8.01F, 2), cube(60, 8.01F, 2), {kBlocks, kBlock, flags}, 16));
  EXPECT_FALSE(is_clear(cube(2, 8.01F, 2), cube(60, 8.01F, 2), {kBlocks, kBlock, flags}, 1.0 / 64));
}

TEST(ClearPaths, AnElementSeesItselfThroughItsOwnBlocks) {
  std::vector<std::uint8_t> flags(512, 1);
  EXPECT_TRUE(is_clear(cube(20, 20, 20), cube(20, 20, 20), {kBlocks, kBlock, flags}, 0.5));
  flags[2 + 8 * (2 + 8 * 2)] = 0;
  EXPECT_FALSE(is_clear(cube(20, 20, 20), cube(20, 20, 20), {kBlocks, kBlock, flags}, 0.5));
}

TEST(ClearPaths, TheirFactorIsThatOfTheGeometryAlone) {
  const PairFactor factor = clear_factor(cube(2, 2, 2), cube(2, 2, 42), 9, {.rays = 4096}, {1, 1, 1});
  EXPECT_TRUE(factor.clear);
  EXPECT_NEAR(factor.transported, 1 / (M_PI * 1600), 1e-3 / (M_PI * 1600));
  EXPECT_EQ(static_cast<float>(factor.transported), static_cast<float>(factor.geometric));
}

}  // namespace
}  // namespace gicube

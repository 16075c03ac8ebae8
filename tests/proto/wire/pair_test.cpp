#include "gicube/wire/pair.h"

#include <gtest/gtest.h>

namespace gicube::wire {
namespace {

TEST(Pair, RecordsGoThereAndBack) {
  const Element element{ElementKind::kBox, {1, 2.5F, 3}, {4, 0, 0}, {0, 5, 0}, {0, 0, -6}};
  std::array<std::uint8_t, kElementBytes> element_bytes{};
  encode(element, element_bytes);
  EXPECT_EQ(decode<Element>(element_bytes), element);
  EXPECT_EQ(load<std::uint32_t>(element_bytes, 12), 0x40200000u);  // 2.5

  const PairsHeader header{7, 8, 9, 10, 11, 12};
  std::array<std::uint8_t, kPairsHeaderBytes> header_bytes{};
  encode(header, header_bytes);
  EXPECT_EQ(decode<PairsHeader>(header_bytes), header);
  EXPECT_EQ(load<std::uint32_t>(header_bytes, 0), 6u);

  const Pair pair{1, 2, 0xDEADBEEF};
  std::array<std::uint8_t, kPairBytes> pair_bytes{};
  encode(pair, pair_bytes);
  EXPECT_EQ(decode<Pair>(pair_bytes), pair);

  const PairResult result{0.1, 0.25F, 1e-3F};
  std::array<std::uint8_t, kPairResultBytes> result_bytes{};
  encode(result, result_bytes);
  EXPECT_EQ(decode<PairResult>(result_bytes), result);
}

// Kept for ever: results of one version of the protocol stay what they are.
TEST(Pair, PointsAreTheseOnes) {
  const double step = pair_coordinate(5, 7, kPairRuns, 0) - pair_coordinate(5, 7, 0, 0);
  EXPECT_NEAR(step - std::floor(step), 0.898653712628699293, 1e-12);
  const double last = pair_coordinate(5, 7, kPairRuns, 5) - pair_coordinate(5, 7, 0, 5);
  EXPECT_NEAR(last - std::floor(last), 0.526688986700735982, 1e-12);
}

TEST(Pair, PointsFillAnElementEvenly) {
  std::array<int, 16> cells{};
  for (std::uint32_t i = 0; i < 1600; ++i) {
    const auto x = static_cast<std::size_t>(pair_coordinate(3, 1, i, 1) * 4);
    const auto y = static_cast<std::size_t>(pair_coordinate(3, 1, i, 4) * 4);
    ++cells[x + 4 * y];
  }
  for (const int count : cells) EXPECT_NEAR(count, 100, 12);  // at random it would be 100 +- 30
}

TEST(Pair, RunsAreIndependentOfEachOther) {
  double products = 0;
  constexpr int kPairs = 4000;
  for (std::uint32_t id = 0; id < kPairs; ++id) {
    products += (pair_coordinate(id, 0, 0, 2) - 0.5) * (pair_coordinate(id, 0, 1, 2) - 0.5);
  }
  EXPECT_NEAR(products / kPairs, 0, 4.0 / 12 / std::sqrt(kPairs));  // four standard errors
}

TEST(Pair, TheWeightIsTheKernelOfAFormFactor) {
  const Element floor{ElementKind::kPatch, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {}};
  const Element ceiling{ElementKind::kPatch, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {}};
  const Vector spacing{1, 1, 1};
  const std::array normals{normal_of(floor, spacing), normal_of(ceiling, spacing)};
  EXPECT_EQ(normals[0], (Vector{0, 0, 1}));
  EXPECT_EQ(normals[1], (Vector{0, 0, -1}));
  const PairSample sample = pair_sample(floor, ceiling, normals, spacing, 0, 0, 0);
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) square += std::pow(sample.to[axis] - sample.from[axis], 2);
  EXPECT_NEAR(sample.weight, 1 / (std::numbers::pi * square * square), 1e-12);  // both cosines are 1 / r
  const std::array away{normals[0], normals[0]};
  EXPECT_EQ(pair_sample(floor, floor, away, spacing, 0, 0, 0).weight, 0);
}

TEST(Pair, TheStandardErrorIsThatOfEightRuns) {
  PairSum few(7), many(16);
  for (std::uint32_t i = 0; i < 7; ++i) few.add(i, 1, 1);
  EXPECT_EQ(few.result().standard_error, std::numeric_limits<float>::infinity());
  for (std::uint32_t i = 0; i < 16; ++i) many.add(i, 2, i % 8 < 4 ? 1 : 0.5);
  EXPECT_DOUBLE_EQ(many.result().transported, 1.5);
  EXPECT_FLOAT_EQ(many.result().geometric, 2);
  EXPECT_FLOAT_EQ(many.result().standard_error, static_cast<float>(1.8 * std::sqrt(8 * 0.25 / 56)));
}

}  // namespace
}  // namespace gicube::wire

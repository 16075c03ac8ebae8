#include "gicube/wire/pair.h"

#include "test.h"

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
  struct Row {
    std::uint32_t index;
    std::array<double, 6> point;  // of 2^32
  };
  constexpr std::array<Row, 3> kRows{
      {{0, {1439158781, 1062165901, 3875307857, 975475894, 354229174, 2079805221}},
       {1, {3856428289, 3865393743, 707610347, 3939927600, 3825460690, 3567445513}},
       {77777, {3973102271, 1045937587, 1706422153, 1531100393, 4244195939, 253484073}}}};
  for (const auto& [index, point] : kRows) {
    for (std::size_t d = 0; d < 6; ++d) EXPECT_EQ(pair_point(5, 7, index)[d] * 0x1p32, point[d]) << index << ' ' << d;
  }
}

// Of 2^m samples from a multiple of 2^m on one lies in each interval of 2^-m, on every axis.
TEST(Pair, PointsAreStratifiedInEveryRun) {
  constexpr std::uint32_t kPoints = 64;
  for (std::uint32_t first = 0; first < 8 * kPoints; first += kPoints) {
    std::array<std::set<int>, 6> hit;
    for (std::uint32_t i = first; i < first + kPoints; ++i) {
      for (std::size_t d = 0; d < 6; ++d) hit[d].insert(static_cast<int>(pair_point(9, 2, i)[d] * kPoints));
    }
    for (const auto& intervals : hit) EXPECT_EQ(intervals.size(), kPoints) << first;
  }
}

// The two coordinates of a flat element, and those of both elements' first ones, are nets.
TEST(Pair, PointsFillAnElementEvenly) {
  for (const std::array<std::size_t, 2> axes : {std::array<std::size_t, 2>{0, 1}, {3, 4}, {1, 4}}) {
    std::array<int, 16> cells{};
    for (std::uint32_t i = 0; i < 1600; ++i) {
      const auto point = pair_point(3, 1, i);
      const auto x = static_cast<std::size_t>(point[axes[0]] * 4), y = static_cast<std::size_t>(point[axes[1]] * 4);
      ++cells[x + 4 * y];
    }
    for (const int count : cells) EXPECT_NEAR(count, 100, 4);  // at random it would be 100 +- 30
  }
}

TEST(Pair, CosineAndSineAreExactToTheLastDigits) {
  for (int i = 0; i <= 100'000; ++i) {
    const double turn = i / 100'000.0, angle = 2 * std::numbers::pi * turn;
    const auto [cosine, sine] = cosine_sine(turn);
    ASSERT_NEAR(cosine, std::cos(angle), 1e-13) << turn;
    ASSERT_NEAR(sine, std::sin(angle), 1e-13) << turn;
  }
  EXPECT_EQ(cosine_sine(0.5).cosine, -1);
  EXPECT_EQ(cosine_sine(1).cosine, 1);
}

TEST(Pair, PointsFillATriangleEvenly) {
  const Element triangle{ElementKind::kTriangle, {1, 2, 3}, {4, 0, 0}, {0, 4, 0}, {}};
  std::array<int, 16> cells{};  // a square's lower half, of 4 x 4 squares: those on its edge are halved too
  for (std::uint32_t i = 0; i < 16'000; ++i) {
    const Vector at = point_of(triangle, {pair_point(3, 1, i)[0], pair_point(3, 1, i)[1], 0.7});
    const double s = at[0] - 1, t = at[1] - 2;
    ASSERT_TRUE(s >= 0 && t >= 0 && s + t <= 4 && at[2] == 3);
    ++cells[static_cast<std::size_t>(s) + 4 * static_cast<std::size_t>(t)];
  }
  for (std::size_t x = 0; x < 4; ++x) {
    for (std::size_t y = 0; x + y < 4; ++y)
      EXPECT_NEAR(cells[x + 4 * y], x + y == 3 ? 1000 : 2000, 60) << x << ' ' << y;
  }
}

TEST(Pair, PointsFillADiscARingAndASectorEvenly) {
  for (const auto& [hole, cut] : {std::pair{0.0F, 0.0F}, {0.25F, 0.0F}, {0.0F, 0.4F}, {0.5F, 0.75F}}) {
    const Element disc{ElementKind::kDisc, {10, 20, 3}, {0, 6, 0}, {0, 0, 2}, {hole, cut, 0}};
    std::array<int, 16> cells{};  // four rings of equal area, four angles each
    for (std::uint32_t i = 0; i < 16'000; ++i) {
      const Vector at = point_of(disc, {pair_point(3, 1, i)[0], pair_point(3, 1, i)[1], 0.7});
      const double s = (at[1] - 20) / 6, t = (at[2] - 3) / 2;
      const double share = (s * s + t * t - hole) / (1 - hole);
      double turn = std::atan2(t, s) / (2 * std::numbers::pi);
      turn = (turn < 0 ? turn + 1 : turn) / (1 - cut);
      ASSERT_EQ(at[0], 10);
      ASSERT_TRUE(share >= -1e-7 && share <= 1 + 1e-7 && turn <= 1 + 1e-7) << share << ' ' << turn;
      const auto cell = [](double x) { return static_cast<std::size_t>(std::clamp(4 * x, 0.0, 3.5)); };
      ++cells[cell(share) + 4 * cell(turn)];
    }
    for (const int count : cells) EXPECT_NEAR(count, 1000, 60) << hole << ' ' << cut;
  }
}

TEST(Pair, BoundsAreThoseOfAllPoints) {
  for (std::uint32_t trial = 0; trial < 400; ++trial) {
    const auto any = [trial](std::uint32_t i) { return static_cast<float>(pair_point(trial, 5, i)[i % 6]) - 0.5F; };
    Element element{
        static_cast<ElementKind>(trial % 4), {1, 2, 3}, {any(0), any(1), any(2)}, {any(3), any(4), any(5)}, {}};
    if (element.kind == ElementKind::kBox) element.w = {any(6), any(7), any(8)};
    if (element.kind == ElementKind::kDisc && trial > 50) element.w = {any(6) + 0.5F, any(7) + 0.5F, 0};
    Vector low{9, 9, 9}, high{-9, -9, -9};
    for (int i = 0; i <= 40; ++i) {
      for (int j = 0; j <= 40; ++j) {
        for (const double r : {0.0, 1.0}) {
          const Vector at = point_of(element, {i / 40.0, j / 40.0, r});
          for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], at[axis]), high[axis] = std::max(high[axis], at[axis]);
          }
        }
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto [least, most] = bounds_of(element, axis);
      EXPECT_LE(least, low[axis] + 1e-12) << trial;
      EXPECT_GE(most, high[axis] - 1e-12) << trial;
      EXPECT_NEAR(least, low[axis], 0.003) << trial;  // the points are a 40th of a turn apart
      EXPECT_NEAR(most, high[axis], 0.003) << trial;
    }
  }
}

TEST(Pair, AnElementMayBeARoundingBeyondTheVolumeAndNoMore) {
  const Vector last{39, 39, 39};
  const auto disc = [](float radius) { return Element{ElementKind::kDisc, {20, 5, 5}, {0, radius, 0}, {0, 0, 5}, {}}; };
  EXPECT_TRUE(lies_within(disc(5), last));
  EXPECT_TRUE(lies_within(disc(5.00001F), last));
  EXPECT_FALSE(lies_within(disc(5.00003F), last));
  EXPECT_FALSE(lies_within({ElementKind::kTriangle, {1, 1, 1}, {38.001F, 0, 0}, {0, 1, 0}, {}}, last));
  for (const auto kind : {ElementKind::kPatch, ElementKind::kBox, ElementKind::kTriangle, ElementKind::kDisc}) {
    EXPECT_FALSE(
        lies_within({kind, {20, 20, 20}, {0, std::numeric_limits<float>::quiet_NaN(), 0}, {1, 0, 0}, {}}, last));
  }
  const Ray at_face = segment_packet({20, -1e-5, 39.00001}, {20, 20, 20}, 1);
  EXPECT_EQ(at_face.position[1], 0u);
  EXPECT_EQ(at_face.position[2], 39u * kVoxel);
}

TEST(Pair, PointsOfPairsSeedsAndCoordinatesAreIndependent) {
  constexpr int kPairs = 4000;
  double of_pairs = 0, of_seeds = 0, of_coordinates = 0;
  for (std::uint32_t id = 0; id < kPairs; ++id) {
    const double here = pair_point(id, 0, 3)[2] - 0.5;
    of_pairs += here * (pair_point(id + 1, 0, 3)[2] - 0.5);
    of_seeds += here * (pair_point(id, 1, 3)[2] - 0.5);
    of_coordinates += here * (pair_point(id, 0, 3)[5] - 0.5);
  }
  for (const double products : {of_pairs, of_seeds, of_coordinates}) {
    EXPECT_NEAR(products / kPairs, 0, 4.0 / 12 / std::sqrt(kPairs));  // four standard errors
  }
}

// Samples 0..99 by eights: the first run has 13 of them.
TEST(Pair, RunsFollowOneAnother) {
  PairSum sum(100);
  for (std::uint32_t i = 0; i < 100; ++i) sum.add(i, 2, i < 13 ? 1 : 0.5);
  const PairResult result = sum.result();
  EXPECT_FLOAT_EQ(result.geometric, 2);
  EXPECT_DOUBLE_EQ(result.transported, (13 * 2 + 87) / 100.0);
  const double off = 2 - result.transported, others = 1 - result.transported;
  EXPECT_NEAR(result.standard_error, 1.8 * std::sqrt((off * off + 7 * others * others) / 56), 1e-6);
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

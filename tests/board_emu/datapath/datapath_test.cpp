// The pipeline's stages against plain double-precision arithmetic and hand-worked words.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "datapath/advance.h"
#include "datapath/classify.h"
#include "datapath/composite.h"
#include "datapath/jitter.h"
#include "datapath/opacity_correction.h"
#include "datapath/ray_step.h"
#include "datapath/resample.h"
#include "datapath/shade.h"
#include "gicube/wire/registers.h"

namespace gicube::emu {
namespace {

TEST(Fixed, DividesByFullScaleWithRoundingForEveryProductOfEightBits) {
  for (std::uint64_t a = 0; a < 256; ++a) {
    for (std::uint64_t b = 0; b < 256; ++b) {
      EXPECT_EQ(divide_by_full_scale<8>(a * b),
                static_cast<std::uint64_t>(std::lround(static_cast<double>(a * b) / 255)));
    }
  }
}

TEST(Fixed, KeepsAWordUnderFullScale) {
  for (const std::uint64_t x : {0u, 1u, 4095u, 0x7FFFFFu, 0xFFFFFFu})
    EXPECT_EQ(divide_by_full_scale<24>(x * wire::kOpacityOne), x);
}

TEST(Resample, GivesTheVoxelItselfAtAVoxel) {
  std::vector<DecodedVoxel> cell(8);
  for (std::size_t i = 0; i < 8; ++i) cell[i].channel = {static_cast<std::int16_t>(1000 * i), 16352, -16352, 7};
  const Neighbourhood at{cell.data(), 2, 4, {0, 0, 0}};
  EXPECT_EQ(resample(at, 0), 0);
  EXPECT_EQ(resample_all(at), (Channels{0, 16352, -16352, 7}));
}

TEST(Resample, GivesTheSameBitsInLanesAsChannelByChannel) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> density(0, 4095 << kDensityFractionBits), gradient(-16352, 16352),
      fraction(0, wire::kVoxel - 1);
  for (int trial = 0; trial < 100'000; ++trial) {
    std::vector<DecodedVoxel> cell(8);
    for (auto& voxel : cell) {
      const bool extreme = trial % 3 == 0;
      const auto component = [&] {
        const int g = gradient(random);
        return static_cast<std::int16_t>(extreme ? (g < 0 ? -16352 : 16352) : g);
      };
      voxel.channel = {static_cast<std::int16_t>(density(random)), component(), component(), component()};
    }
    const auto weights = [&] { return weight(static_cast<std::uint32_t>(trial % 5 == 0 ? 0 : fraction(random))); };
    const Neighbourhood at{cell.data(), 2, 4, {weights(), weights(), weights()}};
    ASSERT_EQ(resample_all(at), resample_each(at)) << trial;
  }
}

TEST(Resample, StaysWithinOneAndAHalfUnitsOfTheExactTrilinearValue) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> density(0, 4095 << kDensityFractionBits), fraction(0, wire::kVoxel - 1);
  for (int trial = 0; trial < 20'000; ++trial) {
    std::vector<DecodedVoxel> cell(8);
    for (auto& voxel : cell) voxel.channel[0] = static_cast<std::int16_t>(density(random));
    const std::array<int, 3> f{fraction(random), fraction(random), fraction(random)};
    double exact = 0;
    for (int i = 0; i < 8; ++i) {
      double w = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const double t = f[static_cast<std::size_t>(axis)] / double{wire::kVoxel};
        w *= (i >> axis & 1) != 0 ? t : 1 - t;
      }
      exact += w * cell[static_cast<std::size_t>(i)].density();
    }
    const Neighbourhood at{cell.data(),
                           2,
                           4,
                           {weight(static_cast<std::uint32_t>(f[0])), weight(static_cast<std::uint32_t>(f[1])),
                            weight(static_cast<std::uint32_t>(f[2]))}};
    EXPECT_NEAR(resample(at, 0), exact, 1.5);  // three roundings in a row
  }
}

TEST(Resample, LerpsOppositeUnitGradientsWithoutOverflow) {
  const auto one = static_cast<std::int16_t>(kGradientUnit);
  EXPECT_EQ(lerp(static_cast<std::int16_t>(-one), one, 1 << 14), 0);
  EXPECT_EQ(lerp(one, static_cast<std::int16_t>(-one), (1 << 15) - 1), -one + 1);
}

TEST(Classify, RoundsToTheNearestDensityAndKeepsTheGreatestInRange) {
  EXPECT_EQ(segmentation_index(8 * 100 + 3, 0), 100u);
  EXPECT_EQ(segmentation_index(8 * 100 + 4, 0), 101u);
  EXPECT_EQ(segmentation_index(4095 << 3, 3), wire::kSegmentationEntries - 1);
}

TEST(OpacityCorrection, IsWithinTwentyUnitsOf24BitsForEveryOpacityAndManyExponents) {
  const OpacityCorrection correct;
  double worst = 0;
  for (const double e : {1.0 / 64, 0.25, 0.5, 0.75, 1.0, 1.7320508, 4.0, 16.0}) {
    const auto exponent = static_cast<std::uint32_t>(std::lround(e * 65536));
    for (std::uint32_t alpha = 0; alpha <= 65535; ++alpha) {
      const double exact = (1 - std::pow(1 - alpha / 65535.0, exponent / 65536.0)) * wire::kOpacityOne;
      worst = std::max(worst, std::abs(exact - correct(static_cast<std::uint16_t>(alpha), exponent)));
    }
  }
  EXPECT_LT(worst, 20);  // 1.2e-6: the tables' linear segments, times the largest exponent
}

TEST(OpacityCorrection, KeepsFullOpacityAndNoneForEveryExponent) {
  const OpacityCorrection correct;
  for (std::uint32_t exponent = 1; exponent < (1u << 26); exponent = exponent * 3 + 1) {
    EXPECT_EQ(correct(65535, exponent), wire::kOpacityOne);
    EXPECT_EQ(correct(0, exponent), 0u);
  }
}

TEST(OpacityCorrection, GrowsWithOpacityAndWithTheExponent) {
  const OpacityCorrection correct;
  for (std::uint32_t exponent : {1024u, 32768u, 65536u, 200'000u}) {
    std::uint32_t before = 0;
    for (std::uint32_t alpha = 0; alpha <= 65535; ++alpha) {
      const std::uint32_t now = correct(static_cast<std::uint16_t>(alpha), exponent);
      ASSERT_GE(now, before) << alpha;
      before = now;
    }
  }
  for (const std::uint16_t alpha : {std::uint16_t{1}, std::uint16_t{100}, std::uint16_t{30000}, std::uint16_t{65534}}) {
    std::uint32_t before = 0;
    for (std::uint32_t exponent = 1024; exponent < (1u << 24); exponent += exponent / 7) {
      const std::uint32_t now = correct(alpha, exponent);
      ASSERT_GE(now, before);
      before = now;
    }
  }
}

TEST(OpacityCorrection, KeepsTheTransmittanceOfThinFogOver512Steps) {
  // 8-bit opacity would lose this fog; 24 bits must keep it.
  const OpacityCorrection correct;
  for (const double alpha : {0.0004, 0.002, 0.01}) {
    const auto word = static_cast<std::uint16_t>(std::lround(alpha * 65535));
    RayState ray;
    for (int step = 0; step < 512; ++step) over(ray, {0, 0, 0}, correct(word, 32768));
    EXPECT_NEAR(1 - ray.opacity / double{wire::kOpacityOne}, std::pow(1 - word / 65535.0, 256), 3e-5);
  }
}

TEST(Composite, MakesAFullSampleFullAndLeavesNothingForTheNext) {
  RayState ray;
  over(ray, {4095, 2000, 0}, wire::kOpacityOne);
  EXPECT_EQ(ray.opacity, wire::kOpacityOne);
  EXPECT_EQ(ray.colour, (std::array<std::uint16_t, 3>{4095, 2000, 0}));
  over(ray, {4095, 4095, 4095}, wire::kOpacityOne);
  EXPECT_EQ(ray.colour, (std::array<std::uint16_t, 3>{4095, 2000, 0}));
  EXPECT_EQ(contribution(ray.opacity), 0);
}

TEST(Composite, FollowsPorterAndDuffWithinTheRoundingOfItsWords) {
  RayState ray;
  double colour = 0, opacity = 0;
  for (int i = 0; i < 100; ++i) {
    const std::uint32_t alpha = 300'000 + 1000u * static_cast<unsigned>(i);
    over(ray, {3000, 0, 0}, alpha);
    const double a = alpha / double{wire::kOpacityOne};
    colour += (1 - opacity) * a * 3000 / 4095;
    opacity += (1 - opacity) * a;
  }
  EXPECT_NEAR(ray.opacity / double{wire::kOpacityOne}, opacity, 100 * 3e-8);
  EXPECT_NEAR(ray.colour[0] / 4095.0, colour, 100 * 0.5 / 4095);
}

TEST(Jitter, DrawsFactorsBetweenAHalfAndOneWithAMeanOfThreeQuarters) {
  double sum = 0;
  for (const std::uint32_t r : kJitterLut) {
    EXPECT_GE(r, kJitterOne / 2);
    EXPECT_LE(r, kJitterOne);
    sum += r;
  }
  EXPECT_NEAR(sum / kJitterEntries / kJitterOne, 0.75, 1e-4);
}

TEST(Jitter, SpreadsEvenlyOverNeighbouringPixelsAndPositions) {
  std::vector<int> seen(8);
  for (int i = 0; i < 64; ++i) {
    for (int j = 0; j < 64; ++j) {
      const std::uint32_t r = jitter({i * 8192, j * 16384, 100}, static_cast<std::uint16_t>(16 * i + 8),
                                     static_cast<std::uint16_t>(16 * j + 8));
      ++seen[(r - kJitterOne / 2) * 8 / (kJitterOne / 2)];
    }
  }
  for (const int count : seen) EXPECT_NEAR(count, 512, 110);  // about five standard deviations
}

TEST(Advance, RoundsAStepToTheNearestUnit) {
  EXPECT_EQ(step_vector({16384, -16384, 0}, 32768), (Point{8192, -8192, 0}));
  EXPECT_EQ(step_vector({9459, 9459, -9459}, 65536), (Point{9459, 9459, -9459}));
}

TEST(Advance, LeapsToTheFirstSampleOutsideTheBlockForEveryPositionAndDirection) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> coordinate(0, 8 * wire::kVoxel - 1), component(-9000, 9000);
  const Point low{8 * wire::kVoxel, 0, 16 * wire::kVoxel};
  for (int trial = 0; trial < 20'000; ++trial) {
    Point position, step;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = low[axis] + coordinate(random);
      step[axis] = trial % 4 == 0 && axis == 0 ? 0 : component(random);
    }
    if (step == Point{}) continue;
    const std::int32_t steps = leap_steps(position, step, low, 8 * wire::kVoxel);
    const auto within = [&](std::int64_t k) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t p = position[axis] + k * step[axis];
        if (p < low[axis] || p >= low[axis] + 8 * wire::kVoxel) return false;
      }
      return true;
    };
    ASSERT_TRUE(within(steps - 1));
    ASSERT_FALSE(within(steps));
  }
}

// On the wide datapath, whose steps are those of the words themselves.
TEST(Advance, FineStepsAreExactHoweverManyAndALeapIsThatManySteps) {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> component(-16'384, 16'384), coordinate(0, 8 * wire::kVoxel - 1);
  std::uniform_int_distribution<std::uint32_t> length(wire::kStepMin, wire::kStepMax);
  Frame frame;
  frame.wide = true;
  frame.extent = {1023 * wire::kVoxel, 1023 * wire::kVoxel, 1023 * wire::kVoxel};
  const Point low{8 * wire::kVoxel, 0, 16 * wire::kVoxel};
  for (int trial = 0; trial < 2000; ++trial) {
    wire::Ray ray;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ray.position[axis] = static_cast<std::uint32_t>(low[axis] + coordinate(random));
      ray.direction[axis] = static_cast<std::int16_t>(component(random));
    }
    ray.direction[static_cast<std::size_t>(trial % 3)] = 9000;  // no short one
    frame.step = trial % 2 == 0 ? wire::kStepMin : length(random);
    RayState one = unpack(ray, frame), leaping = one;
    const std::int32_t steps = leap_steps(leaping, low, 8 * wire::kVoxel, frame);
    for (std::int32_t k = 1; k <= steps; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_GE(one.position[axis], low[axis]) << k;
        ASSERT_LT(one.position[axis], low[axis] + 8 * wire::kVoxel) << k;
      }
      advance(one, 1, frame);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double exact = ray.position[axis] + k * (ray.direction[axis] * (frame.step / 65536.0));
        ASSERT_NEAR(one.position[axis], exact, 0.5);
      }
    }
    advance(leaping, steps, frame);
    ASSERT_EQ(leaping.position, one.position);
    ASSERT_EQ(leaping.rest, one.rest);
    bool outside = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      outside |= one.position[axis] < low[axis] || one.position[axis] >= low[axis] + 8 * wire::kVoxel;
    }
    ASSERT_TRUE(outside);
  }
}

TEST(Advance, LeavesByTheFaceWhosePlaneItCrossesFirst) {
  constexpr Point kExtent{100, 200, 300};
  const auto face = [&](const Point& position, const FinePoint& step) { return face_left_by(position, step, kExtent); };
  EXPECT_EQ(face({-1, 5, 5}, {-10, 0, 0}), 0u);
  EXPECT_EQ(face({101, 5, 5}, {10, 0, 0}), 1u);
  EXPECT_EQ(face({5, -3, 5}, {1, -10, 2}), 2u);
  EXPECT_EQ(face({5, 203, 5}, {1, 10, 2}), 3u);
  EXPECT_EQ(face({5, 5, -1}, {0, 0, -1}), 4u);
  EXPECT_EQ(face({5, 5, 301}, {0, 0, 1}), 5u);
  EXPECT_EQ(face({101, 205, 5}, {10, 10, 0}), 3u) << "y = 200 was crossed half a step ago, x = 100 a tenth";
  EXPECT_EQ(face({105, 201, 5}, {10, 10, 0}), 1u);
  EXPECT_EQ(face({101, 201, 302}, {10, 20, 10}), 5u) << "a fifth, a tenth and a twentieth";
  EXPECT_EQ(face({130, 205, 5}, {10, 1, 0}), 3u) << "a leap of several steps";
  EXPECT_EQ(face({5, 204, 304}, {0, 8, 8}), 3u) << "an edge: the first axis";
  EXPECT_EQ(face({-4, 204, 304}, {-8, 8, 8}), 0u) << "a corner";
  EXPECT_EQ(face({-1, 5, 305}, {0, 0, 10}), 0u) << "beyond x = 0 before this step";
}

TEST(Advance, LeavesAHalfSpaceOnlyWhenItRunsOutOfIt) {
  const Plane plane{{16384, 0, 0}, std::int64_t{10} << kPlaneFractionBits};  // x >= 10
  const Point before{9 * wire::kVoxel, 0, 0}, behind{11 * wire::kVoxel, 0, 0};
  EXPECT_TRUE(beyond(plane, before, {-100, 0, 0}));
  EXPECT_FALSE(beyond(plane, before, {100, 0, 0}));
  EXPECT_FALSE(beyond(plane, behind, {-100, 0, 0}));
  EXPECT_TRUE(fine_beyond(plane, fine(before, kHalfUnits), {-1, 0, 0}));
  EXPECT_FALSE(fine_beyond(plane, fine(before, kHalfUnits), {1, 0, 0}));
  EXPECT_FALSE(fine_beyond(plane, fine(behind, kHalfUnits), {-1, 0, 0}));
  EXPECT_FALSE(fine_beyond(plane, fine({10 * wire::kVoxel, 0, 0}, kHalfUnits), {-1, 0, 0}));
}

TEST(RayState, HasItsWholeStepWithWhatIsBelowAUnit) {
  RayState ray;
  ray.step = {100, -7, 0};
  ray.step_rest = {1 << (kRestBits - 1), 1 << (kRestBits - 2), 0};
  EXPECT_EQ(ray.slope(0), 100.5);
  EXPECT_EQ(ray.slope(1), -6.75);
  EXPECT_EQ(ray.slope(2), 0);
}

TEST(Resample, OfABlockOfDensitiesTakesItsRowsAndSlices) {
  std::array<std::int16_t, 27> densities{};
  densities[13] = 800;  // in the middle of 3^3
  const BlockView view{nullptr, densities.data(), nullptr};
  const auto at = [&view](std::size_t x, std::size_t y, std::size_t z, const std::array<std::uint32_t, 3>& fraction) {
    Cell cell;
    cell.fraction = fraction;
    return resample_view(view, x + 3 * y + 9 * z, cell, 3, 9)[0];
  };
  constexpr std::uint32_t kQuarter = wire::kVoxel / 4;
  EXPECT_EQ(at(0, 1, 1, {kQuarter, 0, 0}), 200);
  EXPECT_EQ(at(1, 0, 1, {0, kQuarter, 0}), 200);
  EXPECT_EQ(at(1, 1, 0, {0, 0, kQuarter}), 200);
  EXPECT_EQ(at(1, 1, 1, {0, kQuarter, 0}), 600);
  EXPECT_EQ(at(1, 1, 1, {0, 0, kQuarter}), 600);
}

// A map whose texels are a linear function of the direction on each face.
std::vector<std::uint8_t> column_map() {
  std::vector<std::uint8_t> map(wire::kReflectanceBytes);
  for (std::size_t i = 0; i < map.size(); ++i) map[i] = static_cast<std::uint8_t>(i % 128);
  return map;
}

TEST(Shade, LooksTheOppositeOfTheGradientUpWithCornerAlignedTexels) {
  const auto map = column_map();
  const auto at = [&map](double b) {
    return reflectance(map.data(), {static_cast<int>(-b * 16352), 0, -16352}) / 256.0;
  };  // normal (b, 0, 1): face +z, column from x
  EXPECT_NEAR(at(-0.9999), 0, 0.02);
  EXPECT_NEAR(at(0), 63.5, 0.01);
  EXPECT_NEAR(at(0.9999), 127, 0.02);
  EXPECT_NEAR(at(0.25), 63.5 * 1.25, 0.05);
}

TEST(Shade, SplitsAShadeAtTheKneeIntoColourAndHighlight) {
  std::vector<std::uint8_t> map(wire::kReflectanceBytes, 192);  // 1.5 everywhere
  wire::SegmentationEntry entry;
  entry.colour = {2000, 1000, 0};
  entry.ambient = 0;
  entry.knee = 128;
  const Colour12 lit = shade(entry, {0, 0, 16000}, map.data());
  EXPECT_EQ(lit, (Colour12{4048, 3048, 2048}));  // colour * 1 + white * 0.5
}

TEST(Shade, LeavesASampleWithoutAGradientAsItIs) {
  std::vector<std::uint8_t> map(wire::kReflectanceBytes, 0);
  wire::SegmentationEntry entry;
  entry.colour = {2000, 1000, 10};
  EXPECT_EQ(shade(entry, {kShortestGradient - 1, 0, 0}, map.data()), (Colour12{2000, 1000, 10}));
  EXPECT_EQ(shade(entry, {kShortestGradient, 0, 0}, map.data()), (Colour12{0, 0, 0}));
}

// Between two points of a volume of 40^3, often on its faces or beside them, where rounding would carry a ray out.
TEST(Segment, TakesAllItsSamplesHoweverItIsRounded) {
  std::mt19937 random(7);
  const auto within = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Frame frame;
  frame.type = wire::RayType::kOpacity;
  frame.extent = {39 * wire::kVoxel, 39 * wire::kVoxel, 39 * wire::kVoxel};
  frame.spacing = {wire::kSpacingOne, wire::kSpacingOne, wire::kSpacingOne};
  const std::uint32_t one = wire::kStepOne;
  for (const auto& [step, wide] : {std::pair{one, false},
                                   {one / 8, false},
                                   {one / 16, false},
                                   {one / 64, false},
                                   {one, true},
                                   {one / 8, true},
                                   {one / 64, true}}) {
    frame.step = step;
    frame.wide = wide;
    for (int i = 0; i < 5000; ++i) {
      std::array<double, 3> from{}, to{}, direction{};
      double length = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double face = within(0, 1) < 0.5 ? 0 : 39, near = face == 0 ? within(0, 0.05) : 39 - within(0, 0.05);
        const int kind = static_cast<int>(within(0, 4));
        from[axis] = kind == 0 ? face : within(0, 39);
        to[axis] = kind == 0 ? near : kind == 1 ? face : within(0, 39);
        length = std::hypot(length, to[axis] - from[axis]);
      }
      wire::Ray ray;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        direction[axis] = (to[axis] - from[axis]) / length;
        ray.position[axis] = static_cast<std::uint32_t>(std::lround(from[axis] * wire::kVoxel));
        ray.direction[axis] =
            static_cast<std::int16_t>(std::lround(direction[axis] * (1 << wire::kDirectionFractionBits)));
      }
      const auto word = static_cast<std::uint32_t>(std::lround(length * 65536));
      ray.set_colour_word(word);
      RayState state = unpack(ray, frame);
      const auto steps = static_cast<std::int32_t>((word + step - 1) / step);
      ASSERT_EQ(state.steps_left(), steps);
      for (std::int32_t taken = 0; taken < steps; ++taken) {
        ASSERT_EQ(end(state, frame), Termination::kNot) << "sample " << taken << " of " << steps;
        advance(state, 1, frame);
        count_steps(state, 1, frame);
      }
      ASSERT_EQ(end(state, frame), Termination::kLeft);
      // Half a unit a voxel by the direction's rounding; on the paper's datapath as much a step by its own.
      const double units = wide ? length / 2 + 4 : 2 * (length + 3 * steps + 4);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_NEAR(state.position[axis] / double{wire::kVoxel}, to[axis] + direction[axis] * length / steps / 2,
                    units / wire::kVoxel);
      }
    }
  }
}

}  // namespace
}  // namespace gicube::emu

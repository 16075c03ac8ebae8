// Steps along a ray, their jitter, leaps, and where a ray leaves the volume.
#include "datapath/advance.h"
#include "datapath/jitter.h"
#include "datapath/ray_step.h"
#include "gicube/wire/registers.h"
#include "test.h"

namespace gicube::emu {
namespace {

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
    const std::int32_t steps = skip_steps(position, step, low, 8 * wire::kVoxel);
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
    const std::int32_t steps = skip_steps(leaping, low, 8 * wire::kVoxel, frame);
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
        ASSERT_EQ(end(state, frame), Termination::kActive) << "sample " << taken << " of " << steps;
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

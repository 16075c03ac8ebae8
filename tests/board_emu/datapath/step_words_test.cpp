// Steps, places and the hashes that are drawn from them against tests/support/reference/words.h, over their whole range
// or a million random words.
#include "datapath/advance.h"
#include "datapath/jitter.h"
#include "datapath/random_stream.h"
#include "datapath/ray_step.h"
#include "gicube/wire/mix64.h"
#include "random_words.h"
#include "reference/words.h"
#include "test.h"

namespace gicube::emu {
namespace {

TEST(PipelineWords, AStepIsTheDirectionTimesItsLengthRoundedHalfUp) {
  Words words(7);
  for (int i = 0; i < kMany; ++i) {
    const std::array<std::int16_t, 3> direction{words.i16(-16384, 16384), words.i16(-16384, 16384),
                                                words.i16(-16384, 16384)};
    const std::uint32_t length = words.u32(0, 16 << 16);
    const Point step = step_vector(direction, length);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(step[axis], reference::nearest(std::int64_t{direction[axis]} * length, 65536));
    }
  }
}

TEST(PipelineWords, AVoxelLengthAlongTheRayIsItsPhysicalLength) {
  Words words(8);
  for (int i = 0; i < 100'000; ++i) {
    const std::array<std::int16_t, 3> direction{words.i16(-9000, 9000), words.i16(-9000, 9000), words.i16(1, 9000)};
    const std::array<std::uint32_t, 3> spacing{words.u32(4096, 1 << 20), words.u32(4096, 1 << 20),
                                               words.u32(4096, 1 << 20)};
    double physical = 0, voxels = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      physical = std::hypot(physical, double(direction[axis]) * spacing[axis]);
      voxels = std::hypot(voxels, double(direction[axis]));
    }
    ASSERT_NEAR(physical_length(direction, spacing), physical / voxels, 0.5 + 1e-6);
  }
  EXPECT_EQ(physical_length({1, 2, 3}, {70'000, 70'000, 70'000}), 70'000u);
  EXPECT_EQ(physical_length({3, 4, 0}, {5 * 65536, 0, 7}), 3u * 65536);
  EXPECT_EQ(physical_length({0, 4, 3}, {7, 0, 5 * 65536}), 3u * 65536);
}

TEST(PipelineWords, ASampleStandsForItsStepTimesThePhysicalLength) {
  Words words(9);
  for (int i = 0; i < kMany; ++i) {
    RayState ray;
    ray.length = words.u32(1, 16 << 16);
    const std::uint32_t distance = words.u32(1, 16 << 16);
    space(ray, distance, {});
    ASSERT_EQ(ray.exponent, reference::nearest(std::int64_t{distance} * ray.length, 65536));
  }
}

TEST(PipelineWords, APositionIsInsideUpToBothFacesOfEachAxis) {
  const Point extent{100, 200, 300};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Point at{50, 60, 70};
    for (const auto& [value, expected] : {std::pair(-1, false), std::pair(0, true), std::pair(extent[axis], true),
                                          std::pair(extent[axis] + 1, false)}) {
      at[axis] = value;
      EXPECT_EQ(inside(at, extent), expected) << axis << ' ' << value;
    }
  }
}

TEST(PipelineWords, ARayOnACutPlaneIsNotBeyondIt) {
  const Plane plane{{0, 16384, 0}, std::int64_t{10} << kPlaneFractionBits};
  const int on = 10 * wire::kVoxel;
  EXPECT_FALSE(beyond(plane, {0, on, 0}, {0, -1, 0}));
  EXPECT_TRUE(beyond(plane, {0, on - 1, 0}, {0, -1, 0}));
  EXPECT_FALSE(beyond(plane, {0, on - 1, 0}, {1, 0, 0})) << "it runs along the plane";
}

// SplitMix64 seeded with 0: its first three numbers (from the generator's own C source).
TEST(PipelineWords, TheHashIsThatOfSplitMix64) {
  constexpr std::uint64_t kGamma = 0x9E3779B97F4A7C15;
  EXPECT_EQ(wire::mix64(kGamma), 0xE220A8397B1DCDAFu);
  EXPECT_EQ(wire::mix64(2 * kGamma), 0x6E789E6AA1B965F4u);
  EXPECT_EQ(wire::mix64(3 * kGamma), 0x06C45D188009454Fu);
}

TEST(PipelineWords, JitterHasEachStratumOnceAndItsPlaceComesFromPositionAndDestination) {
  std::array<std::uint32_t, 256> sorted = kJitterLut;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t i = 0; i < 256; ++i) ASSERT_EQ(sorted[i], 32768 + i * 128 + 64);  // 1/2 + (i + 1/2) / 512
  // Golden entries, shuffled apart from this tree.
  EXPECT_EQ(kJitterLut[0], 47552u);
  EXPECT_EQ(kJitterLut[1], 50880u);
  EXPECT_EQ(kJitterLut[127], 37568u);
  EXPECT_EQ(kJitterLut[255], 39744u);
  int moved = 0;
  for (std::size_t i = 0; i < 256; ++i) moved += kJitterLut[i] != sorted[i];
  EXPECT_GT(moved, 240);
  Words words(10);
  for (int i = 0; i < 100'000; ++i) {
    const Point at{static_cast<int>(words(0, (1 << 24) - 1)), static_cast<int>(words(0, (1 << 24) - 1)),
                   static_cast<int>(words(0, (1 << 24) - 1))};
    const std::uint16_t u = words.u16(0, 65535), v = words.u16(0, 65535);
    // The packet's bits in their order: 24 each of x and y; 24 of z, 16 each of u and v.
    const std::uint64_t low = static_cast<std::uint64_t>(at[0]) + (static_cast<std::uint64_t>(at[1]) << 24);
    const std::uint64_t high = static_cast<std::uint64_t>(at[2]) + (std::uint64_t{u} << 24) + (std::uint64_t{v} << 40);
    ASSERT_EQ(jitter(at, u, v), kJitterLut[reference::mixed(reference::mixed(low) ^ high) & 255]);
  }
}

TEST(PipelineWords, AJitteredStepIsTheStepTimesTheFactor) {
  Frame frame;
  Words words(11);
  for (int i = 0; i < 100'000; ++i) {
    frame.step = words.u32(1, 16 << 16);
    const std::uint32_t factor = words.u32(kJitterOne / 2, kJitterOne);
    ASSERT_EQ(jittered(frame, factor), reference::nearest(std::int64_t{frame.step} * factor, 65536));
  }
}

TEST(PipelineWords, DrawsHashRayFlightPlaceSeedAndPurpose) {
  Words words(12);
  for (int i = 0; i < 100'000; ++i) {
    const std::uint16_t u = words.u16(0, 65535), v = words.u16(0, 65535), lifetime = words.u16(0, 1023);
    const std::uint32_t seed = words.u32(0, 0xFFFF'FFFF);
    const auto what = static_cast<RandomStream>(words(1, 8));
    const std::uint64_t ray = u + (std::uint64_t{v} << 16) + (std::uint64_t{lifetime} << 32);
    const std::uint64_t drawn =
        reference::mixed(reference::mixed(ray) ^ ((std::uint64_t{seed} << 8) + static_cast<std::uint64_t>(what)));
    ASSERT_EQ(draw(what, u, v, lifetime, seed), drawn);
    const Point at{static_cast<int>(words(0, (1 << 24) - 1)), static_cast<int>(words(0, (1 << 24) - 1)),
                   static_cast<int>(words(0, (1 << 24) - 1))};
    const std::uint64_t place = static_cast<std::uint64_t>(at[0]) + (static_cast<std::uint64_t>(at[1]) << 32);
    ASSERT_EQ(draw_at(what, at, u, v, lifetime, seed),
              reference::mixed(reference::mixed(reference::mixed(place) ^ static_cast<std::uint64_t>(at[2])) ^ drawn));
  }
}

}  // namespace
}  // namespace gicube::emu

// The table of optical depths against plain sums over the segmentation LUT: what lies between two densities, and where.
#include "datapath/ray_part.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace gicube::emu {
namespace {

constexpr int kSlices = 20'000;  // of the plain sum

double depth_of(const std::vector<wire::SegmentationEntry>& entries, unsigned tag, double density) {
  const auto index = tag * 4096 + static_cast<std::size_t>(std::clamp(density + 0.5, 0.0, 4095.5));
  return -std::log1p(-entries[index].opacity / 65535.0);
}

std::vector<wire::SegmentationEntry> rough_entries(unsigned seed, bool opaque) {
  std::mt19937 random(seed);
  std::vector<wire::SegmentationEntry> entries(wire::kSegmentationEntries);
  for (wire::SegmentationEntry& entry : entries) {
    const unsigned kind = random() % 64;
    entry.opacity = static_cast<std::uint16_t>(kind == 0 && opaque ? 65535 : kind < 30 ? 0 : random() % 60'000);
  }
  return entries;
}

TEST(DepthTable, BetweenTwoDensitiesIsTheMeanDepthTimesTheLength) {
  const auto entries = rough_entries(1, false);
  const DepthTable table(entries);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> density(0, 4095), near(-3, 3), length(0.1, 4);
  for (int i = 0; i < 300; ++i) {
    const auto tag = static_cast<unsigned>(i % 4);
    const double from = density(random),
                 to = std::clamp(i % 2 == 0 ? density(random) : from + near(random), 0.0, 4095.0), way = length(random);
    double sum = 0;
    for (int s = 0; s < kSlices; ++s) sum += depth_of(entries, tag, from + (to - from) * (s + 0.5) / kSlices) / kSlices;
    const DepthTable::Depth depth = table.between(tag, from, to, way);
    ASSERT_GT(depth.opaque, 1) << "nothing is opaque";
    ASSERT_NEAR(depth.depth, sum * way, 2e-3 * way) << from << ' ' << to;
    ASSERT_DOUBLE_EQ(table.between(tag, to, from, way).depth, depth.depth);
  }
}

TEST(DepthTable, WithoutAWayItIsTheEntrysDepth) {
  const auto entries = rough_entries(2, false);
  const DepthTable table(entries);
  for (int i = 0; i < 4095; ++i) {
    const double at = i + 0.3;
    ASSERT_NEAR(table.between(2, at, at, 0.7).depth, 0.7 * depth_of(entries, 2, at), 1e-12);
    ASSERT_NEAR(table.between(2, at, at + 1e-9, 0.7).depth, 0.7 * depth_of(entries, 2, at), 1e-9);
  }
}

TEST(DepthTable, EndsWhereTheFirstOpaqueEntryBegins) {
  const auto entries = rough_entries(3, true);
  const DepthTable table(entries);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> density(0, 4095), near(-60, 60);
  int walls = 0;
  for (int i = 0; i < 400; ++i) {
    const auto tag = static_cast<unsigned>(i % 4);
    const double from = density(random), to = std::clamp(from + near(random), 0.0, 4095.0);
    int first = kSlices;
    double sum = 0;
    for (int s = 0; s < kSlices && first == kSlices; ++s) {
      const double depth = depth_of(entries, tag, from + (to - from) * (s + 0.5) / kSlices);
      if (std::isinf(depth)) {
        first = s;
      } else {
        sum += depth / kSlices;
      }
    }
    const DepthTable::Depth depth = table.between(tag, from, to, 2);
    ASSERT_EQ(depth.opaque <= 1, first < kSlices) << from << ' ' << to;
    ASSERT_NEAR(depth.depth, 2 * sum, 4e-3);
    if (first == kSlices) continue;
    ++walls;
    ASSERT_NEAR(depth.opaque, first / double{kSlices}, 1.01 / kSlices);
  }
  EXPECT_GT(walls, 100);
}

TEST(DepthTable, FindsTheWayToAShareOfTheDepth) {
  const auto entries = rough_entries(4, false);
  const DepthTable table(entries);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> density(0, 4095), share(0.02, 0.98);
  for (int i = 0; i < 2000; ++i) {
    const double from = density(random), to = i % 2 == 0 ? density(random) : std::min(from + share(random), 4095.0),
                 part = share(random);
    const double all = table.between(1, from, to, 1).depth;
    if (all == 0) {
      ASSERT_EQ(table.way_to(part, 1, from, to), part);
      continue;
    }
    const double way = table.way_to(part, 1, from, to);
    ASSERT_NEAR(table.between(1, from, from + way * (to - from), way).depth, part * all, 1e-7 + 1e-5 * all)
        << from << ' ' << to;
  }
}

TEST(DepthTable, KnowsWhereAllDensitiesHaveOneOpacity) {
  std::vector<wire::SegmentationEntry> entries(wire::kSegmentationEntries);
  for (std::size_t i = 100; i < 200; ++i) entries[i].opacity = 5;
  for (std::size_t i = 4096; i < 8192; ++i) entries[i].opacity = 5;
  const DepthTable table(entries);
  const auto range = [](double least, double greatest) {
    return DensityRange{static_cast<std::int16_t>(least * 8), static_cast<std::int16_t>(greatest * 8)};
  };
  EXPECT_TRUE(table.uniform(0, range(0, 99)));
  EXPECT_TRUE(table.uniform(0, range(99.5, 199.375)));
  EXPECT_FALSE(table.uniform(0, range(99.375, 150)));
  EXPECT_FALSE(table.uniform(0, range(150, 199.5)));
  EXPECT_FALSE(table.uniform(0, range(50, 250))) << "the same at both ends";
  EXPECT_TRUE(table.uniform(0, range(200, 4095)));
  EXPECT_TRUE(table.uniform(1, range(0, 4095)));
}

}  // namespace
}  // namespace gicube::emu

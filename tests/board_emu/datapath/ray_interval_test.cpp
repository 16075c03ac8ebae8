// The table of optical depths against plain sums over the segmentation LUT: what lies between two densities, and where.
#include "datapath/ray_interval.h"

#include "datapath/interaction.h"
#include "lighting_rig.h"
#include "plain_interval.h"
#include "test.h"

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

// A volume of rough densities and a ray whose samples lie in the middle of its cell.
struct Rough {
  explicit Rough(unsigned seed) : lit({5, 5, 5}, 8, false), random(seed) {
    lit.scene.fill([this](int, int, int) { return wire::Voxel{static_cast<std::uint16_t>(1000 + random() % 1000)}; });
    lit.scene.frame.rules = wire::EnergyRules::kConserving;
  }
  RayState ray(const Point& direction, std::uint32_t step) {
    lit.scene.frame.step = step;
    wire::Ray packet;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      packet.direction[axis] = static_cast<std::int16_t>(direction[axis]);
      packet.position[axis] = static_cast<std::uint32_t>((2u << 14) + 7000 + random() % 2000);
    }
    packet.flags = wire::kLightingRay;
    return unpack(packet, lit.scene.frame);
  }
  RayInterval interval(const RayState& ray, bool first) {
    const Frame& frame = lit.scene.frame;
    const Cell at = cell(ray.position, {0, 0, 0});
    const BlockView view = frame.volume->view(0);
    const Sample sample = sample_at(ray.position, frame);
    return RayInterval::of(ray, {at, view, 0, 9}, 0, sample.entry.opacity, first, frame);
  }
  // The density at `steps` from the sample.
  double density(const RayState& ray, double steps) const {
    const BlockView view = lit.scene.frame.volume->view(0);
    std::array<double, 3> f{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      f[axis] = (ray.position[axis] + steps * ray.step[axis]) / wire::kVoxel - 2;
    double sum = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::size_t voxel = 0, stride = 1;
      for (std::size_t axis = 0; axis < 3; ++axis, stride *= 9) {
        const bool upper = (corner >> axis & 1) != 0;
        weight *= upper ? f[axis] : 1 - f[axis];
        voxel += stride * (upper ? 3 : 2);
      }
      sum += weight * view.densities[voxel] / 8.0;
    }
    return sum;
  }

  LitScene lit;
  std::mt19937 random;
};

TEST(RayInterval, HasTheDepthsOfDensitiesThatAreLinearBetweenItsEndsAndTheSample) {
  Rough rough(1);
  for (std::size_t i = 0; i < 4096; ++i)
    rough.lit.scene.segmentation[i].opacity = static_cast<std::uint16_t>(i < 1400 ? 0 : (i - 1400) * 90);
  rough.lit.scene.set_depths();
  const DepthTable& table = *rough.lit.scene.depths;
  for (int i = 0; i < 500; ++i) {
    const RayState ray = rough.ray({9000, -9700, 9600}, wire::kStepOne / 5 + 1);
    for (const bool first : {false, true}) {
      const double length = ray.exponent / 65536.0, middle = rough.density(ray, 0);
      const double before = first ? 0 : table.between(0, rough.density(ray, -0.5), middle, length / 2).depth;
      const double depth = before + table.between(0, middle, rough.density(ray, 0.5), length / 2).depth;
      ASSERT_NEAR(rough.interval(ray, first).opacity(), -std::expm1(-depth) * wire::kOpacityOne, 0.5 + 1e-3);
    }
  }
}

TEST(RayInterval, BeginsAndEndsWherePlainScalarCodeSaysBitForBit) {
  Rough rough(3);
  LitScene& lit = rough.lit;
  for (std::size_t i = 0; i < 4096; ++i) lit.scene.segmentation[i].opacity = 30'000;
  lit.scene.set_depths();
  std::uniform_int_distribution<int> direction(-16384, 16384), step(3000, 150'000);
  std::uniform_int_distribution<std::int32_t> position(0, lit.scene.frame.extent[0]);
  int first_samples = 0, last_samples = 0;
  for (int i = 0; i < 20'000; ++i) {
    Point way{direction(rough.random), i % 3 == 0 ? 0 : direction(rough.random),
              i % 5 == 0 ? 0 : direction(rough.random)};
    if (way == Point{}) way[0] = 1;
    lit.scene.frame.wide = i % 2 == 0;
    RayState ray = rough.ray(way, static_cast<std::uint32_t>(step(rough.random)));
    for (std::int32_t& at : ray.position) at = position(rough.random);
    const bool first = i % 7 == 0,
               last = !inside(units_of(moved(ray.fine_position(), ray.fine_step(), 1)), lit.scene.frame.extent);
    const PlainPath path(ray);
    const BlockView view = lit.scene.frame.volume->view(0);
    const Cell at = cell(ray.position, {0, 0, 0});
    const RayInterval interval = RayInterval::of(ray, {at, view, 0, 9}, 0, 30'000, first, lit.scene.frame);
    const double begin = first ? 0 : path.begin(), end = path.end(lit.scene.frame.extent);
    ASSERT_EQ(interval.place(0, lit.scene.frame), begin) << "ray " << i;
    ASSERT_EQ(interval.place(1, lit.scene.frame), begin + (end - begin)) << "ray " << i;
    first_samples += first ? 1 : 0;
    last_samples += last ? 1 : 0;
  }
  EXPECT_GT(first_samples, 1000);
  EXPECT_GT(last_samples, 1000);
}

TEST(RayInterval, OfOneOpacityIsCorrectedForItsLengthRounded) {
  Rough rough(2);
  for (std::size_t i = 0; i < 4096; ++i) rough.lit.scene.segmentation[i].opacity = 30'000;
  rough.lit.scene.set_depths();
  const OpacityCorrection correct;
  const RayState ray = rough.ray({16384, 0, 0}, 12'001);
  ASSERT_EQ(ray.exponent, 12'001u);
  EXPECT_EQ(rough.interval(ray, false).opacity(), correct(30'000, 12'001));
  EXPECT_EQ(rough.interval(ray, true).opacity(), correct(30'000, 6001)) << "6000.5";
  EXPECT_NE(correct(30'000, 6001), correct(30'000, 6000));
}

// Along x the density grows from 1000 to 2000 in the cell; from 1500 on nothing passes.
TEST(RayInterval, EndsAtAWallAndHasPlacesBeforeIt) {
  Rough rough(3);
  rough.lit.scene.fill([](int x, int, int) { return wire::Voxel{static_cast<std::uint16_t>(x <= 2 ? 1000 : 2000)}; });
  for (std::size_t i = 0; i < 4096; ++i) rough.lit.scene.segmentation[i].opacity = i < 1500 ? 60'000 : 65535;
  rough.lit.scene.set_depths();
  RayState ray = rough.ray({16384, 0, 0}, wire::kStepOne);
  ray.position[0] = (2 << 14) + 4096;
  const RayInterval interval = rough.interval(ray, false);
  EXPECT_EQ(interval.opacity(), wire::kOpacityOne);
  const Frame& frame = rough.lit.scene.frame;
  // Depth 2.47 a voxel before the wall, half a unit below 1500; log 2^25 in it.
  const double fog = -std::log1p(-60'000 / 65535.0), way = 0.4995, all = fog * way + std::log(2.0 * wire::kOpacityOne);
  EXPECT_NEAR(interval.place(0, frame), -0.25, 1e-9);
  EXPECT_NEAR(interval.place(0.25 * fog * way / all, frame), -0.25 + 0.25 * way, 1e-3);
  EXPECT_NEAR(interval.place(0.75 * fog * way / all, frame), -0.25 + 0.75 * way, 1e-3);
  EXPECT_NEAR(interval.place(0.5, frame), -0.25 + way, 1e-3);
}

}  // namespace
}  // namespace gicube::emu

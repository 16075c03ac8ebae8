// The sums that the functional level's tiles and vectors leave are those of samples taken one by one, in any number of
// commands and on any number of threads.
#include "functional/backproject.h"

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "gicube/wire/voxel.h"
#include "machine_rig.h"
#include "memory/accumulator_memory.h"
#include "simd/instruction_sets.h"
#include "test.h"
#include "voxels.h"

namespace gicube::emu {
namespace {

constexpr std::array<int, 3> kSize{70, 41, 66};

// The sums of all voxels, sample by sample.
struct Plain {
  std::vector<std::int64_t> words = std::vector<std::int64_t>(std::size_t{kSize[0]} * kSize[1] * kSize[2]);
  RayCounters counters;

  void add(const wire::Ray& packet, const Frame& frame) {
    RayState ray = unpack(packet, frame);
    ++counters.rays;
    for (; end(ray, frame) == Termination::kActive; advance(ray, 1, frame), count_steps(ray, 1, frame)) {
      const Deposit deposit = spread_at(ray.position, ray.amount());
      ++counters.samples;
      counters.energy.deposited.kept += static_cast<std::uint64_t>(std::int64_t{ray.amount()});
      for (std::size_t i = 0; i < 8; ++i) {
        const auto share = static_cast<std::int32_t>(deposit.shares[i]);
        if (share == 0) continue;  // also of voxels beyond the volume
        const std::size_t x = deposit.voxel[0] + (i & 1), y = deposit.voxel[1] + (i >> 1 & 1),
                          z = deposit.voxel[2] + (i >> 2);
        words.at(x + kSize[0] * (y + kSize[1] * z)) += share;
      }
    }
  }
};

std::vector<std::int64_t> words_of(AccumulatorMemory& accumulators) {
  const auto n = static_cast<std::size_t>(accumulators.block_voxels());
  std::vector<std::uint8_t> bytes(accumulators.bytes());
  accumulators.read(0, bytes);
  std::vector<std::int64_t> words;
  for_each_voxel(kSize, [&](int x, int y, int z) {
    const std::size_t at[] = {static_cast<std::size_t>(x), static_cast<std::size_t>(y), static_cast<std::size_t>(z)};
    const auto nx = static_cast<std::size_t>(accumulators.blocks()[0]),
               ny = static_cast<std::size_t>(accumulators.blocks()[1]);
    const std::size_t block = at[0] / n + nx * (at[1] / n + ny * (at[2] / n));
    const std::uint64_t bits = wire::load36(bytes, block * n * n * n + at[0] % n + n * (at[1] % n + n * (at[2] % n)));
    words.push_back(static_cast<std::int64_t>(bits << 28) >> 28);
  });
  return words;
}

// Rays that cross the volume, run along its faces and edges, are short, or have no length; of all amounts.
wire::Ray random_ray(std::mt19937& random) {
  const auto number = [&](int least, int most) { return std::uniform_int_distribution<int>(least, most)(random); };
  std::array<double, 3> position{}, direction{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int kind = number(0, 9);
    const double last = kSize[axis] - 1;
    position[axis] = kind == 0   ? 0
                     : kind == 1 ? last
                     : kind == 2 ? number(0, kSize[axis] - 1)
                                 : number(0, 10'000) * last / 10'000;
    direction[axis] = number(0, 3) == 0 ? 0 : number(-100, 100) + 0.5;
  }
  if (direction == std::array<double, 3>{}) direction[1] = -1;
  wire::Ray ray = host_ray(1, position, direction);
  ray.set_colour_word(static_cast<std::uint64_t>(number(0, 5) == 0 ? number(0, 1 << 16) : number(0, 110 << 16)));
  const int most = std::array{9, 1 << 15, 1 << 17, wire::kMaxAmount}[static_cast<std::size_t>(number(0, 3))];
  const std::int32_t amount = std::clamp(number(-most - 1, most + 1), -wire::kMaxAmount, wire::kMaxAmount);
  ray.opacity = static_cast<std::uint32_t>(amount) & wire::kOpacityOne;
  return ray;
}

TEST(Backproject, LeavesWhatSamplesLeaveOneByOne) {
  std::mt19937 random(11);
  for (const int n : {8, 16, 32, 64}) {
    for (const bool wide : {false, true}) {
      for (const std::uint32_t step : {1u << 10, 40'000u, 1u << 16, 3u << 16}) {
        SCOPED_TRACE(testing::Message() << n << ' ' << wide << ' ' << step);
        Scene scene(kSize, n);
        if (wide) scene.widen();
        AccumulatorMemory accumulators(n);
        accumulators.resize(kSize);
        Frame frame = scene.frame;
        frame.type = wire::RayType::kBackproject;
        frame.step = step;
        frame.opacity_threshold = wire::kOpacityOne;
        frame.jitter = frame.skip_empty = false;
        frame.accumulators = &accumulators;
        Plain plain;
        RayCounters counters;
        for (const unsigned threads : {1u, 3u, 2u}) {
          std::vector<wire::Ray> rays;
          for (int i = 0; i < 150; ++i) rays.push_back(random_ray(random));
          for (const wire::Ray& ray : rays) plain.add(ray, frame);
          counters += backproject(rays, frame, threads);
          EXPECT_EQ(accumulators.settle().words, 0u);
        }
        EXPECT_EQ(counters.rays, plain.counters.rays);
        EXPECT_EQ(counters.samples, plain.counters.samples);
        EXPECT_EQ(counters.energy.deposited.kept, plain.counters.energy.deposited.kept);
        EXPECT_EQ(words_of(accumulators), plain.words);
      }
    }
  }
}

// More rays of one line than the cells' words hold, and more than may wait.
TEST(Backproject, CellsAreBroughtToTheWordsBeforeTheyAreFull) {
  constexpr std::array<int, 3> kSmall{16, 8, 8};
  Scene scene(kSmall, 8);
  wire::Ray ray = host_ray(1, {0, 3, 5}, {1, 0, 0});
  ray.set_colour_word(15 << 16);
  ray.opacity = static_cast<std::uint32_t>(-wire::kMaxAmount) & wire::kOpacityOne;
  const std::vector<wire::Ray> rays(400, ray);  // 400 x 2^23, which takes 32 bits
  on_every_target([&] {
    AccumulatorMemory accumulators(8);
    accumulators.resize(kSmall);
    Frame frame = scene.frame;
    frame.type = wire::RayType::kBackproject;
    frame.step = 1 << 16;
    frame.opacity_threshold = wire::kOpacityOne;
    frame.jitter = frame.skip_empty = false;
    frame.accumulators = &accumulators;
    Overflow overflow;
    for (int command = 0; command < 6; ++command) {
      backproject(rays, frame, 1);
      const Overflow more = accumulators.settle();
      overflow.words += more.words;
      overflow.clipped += more.clipped;
    }
    std::vector<std::uint8_t> bytes(accumulators.bytes());
    accumulators.read(0, bytes);
    const auto word = [&](std::size_t i) { return static_cast<std::int64_t>(wire::load36(bytes, i) << 28) >> 28; };
    EXPECT_EQ(overflow.words, 14u);  // of the 16, the ray's ends get half as much
    EXPECT_EQ(word(7 + 8 * (3 + 8 * 5)), -wire::kMaxSum);
    EXPECT_EQ(overflow.clipped, 14 * (wire::kMaxSum - std::int64_t{wire::kMaxAmount} * 2400));
  });
}

}  // namespace
}  // namespace gicube::emu

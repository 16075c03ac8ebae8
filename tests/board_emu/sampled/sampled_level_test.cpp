// The sampled level behind the board's connector: the functional level's values, and times within their intervals of the cycle level's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bare_board.h"
#include "config/config.h"

namespace gicube::emu {
namespace {

constexpr std::array<int, 3> kSize{30, 26, 28};

v1::BoardConfig board_config(unsigned error, v1::FidelityLevel level = v1::cycle) {
  v1::BoardConfig config;
  config.set_fidelity(level);
  config.set_threads(1);
  config.set_sample_error(error);
  config.mutable_asic()->set_block_voxels(8);
  return config;
}

void load(BareBoard& board) {
  board.load_volume(kSize, [](int x, int y, int z) {
    return wire::Voxel{static_cast<std::uint16_t>((x * 37 + y * 91 + z * 53) % 4096), 0, 0, 0};
  });
  board.write_segmentation([](unsigned, unsigned density) {
    return wire::SegmentationEntry{{2048, 1024, 512}, static_cast<std::uint16_t>(density / 8)};
  });
}

// Host rays that turn from command to command.
std::vector<wire::Ray> rays_of(int command) {
  std::vector<wire::Ray> rays;
  for (unsigned i = 0; i < 250; ++i) {
    const double turn = 0.02 * command;
    rays.push_back(
        host_ray(i, {i % 25 + 0.4, i * 13 % 25 + 0.7, 1.0}, {std::sin(turn), 0.1 * (i % 7), std::cos(turn)}));
  }
  return rays;
}

struct Series {
  std::vector<std::vector<wire::Ray>> rays;
  std::uint64_t cycles = 0, within = 0, commands = 0, estimated = 0, packets = 0, packets_within = 0;
  std::uint64_t now = 0;
};

Series carry_out(const v1::BoardConfig& config, int commands) {
  BareBoard board(config);
  load(board);
  Series series;
  for (int i = 0; i < commands; ++i) series.rays.push_back(board.trace(rays_of(i)));
  series.cycles = board.counter("asic.cycles");
  series.packets = board.counter("rdram.reads") + board.counter("rdram.writes");
  series.now = board.now_ps;
  if (config.sample_error() == 0) return series;
  series.within = board.counter("sampled.cycles_within");
  series.packets_within = board.counter("sampled.packets_within");
  series.commands = board.counter("sampled.commands");
  series.estimated = board.counter("sampled.estimated_commands");
  EXPECT_EQ(board.counter("fidelity_answered.functional"), series.estimated);
  EXPECT_EQ(board.counter("fidelity_answered.cycle"), series.commands - series.estimated);
  return series;
}

double apart(std::uint64_t a, std::uint64_t b) { return std::abs(static_cast<double>(a) - static_cast<double>(b)); }

TEST(SampledLevel, HasTheCycleLevelsValuesAndItsTimeWithinTheInterval) {
  const Series all = carry_out(board_config(0), 80), sampled = carry_out(board_config(50), 80);
  EXPECT_EQ(sampled.rays, all.rays);
  EXPECT_EQ(sampled.commands, 80u);
  EXPECT_GT(sampled.estimated, 30u);
  EXPECT_GT(sampled.within, 0u);
  EXPECT_LE(static_cast<double>(sampled.within), 0.05 * static_cast<double>(sampled.cycles));
  EXPECT_LE(apart(sampled.cycles, all.cycles), static_cast<double>(sampled.within));
  EXPECT_LE(apart(sampled.packets, all.packets), static_cast<double>(sampled.packets_within));
  // 10 ns a cycle: commands take what was estimated.
  EXPECT_NEAR(apart(sampled.now, all.now), 10'000 * apart(sampled.cycles, all.cycles),
              0.002 * static_cast<double>(all.now));
}

TEST(SampledLevel, RepeatsExactly) {
  const Series once = carry_out(board_config(50), 60), again = carry_out(board_config(50), 60);
  EXPECT_EQ(once.cycles, again.cycles);
  EXPECT_EQ(once.within, again.within);
  EXPECT_EQ(once.estimated, again.estimated);
  EXPECT_EQ(once.now, again.now);
}

TEST(SampledLevel, OfFewCommandsIsTheCycleLevel) {
  const Series all = carry_out(board_config(0), 6), sampled = carry_out(board_config(100), 6);
  EXPECT_EQ(sampled.estimated, 0u);
  EXPECT_EQ(sampled.within, 0u);
  EXPECT_EQ(sampled.cycles, all.cycles);
  EXPECT_EQ(sampled.now, all.now);
}

TEST(SampledLevel, CountsPartsInTheirSums) {
  BareBoard board(board_config(50));
  load(board);
  for (int i = 0; i < 40; ++i) board.trace(rays_of(i));
  ASSERT_GT(board.counter("sampled.estimated_commands"), 0u);
  std::uint64_t causes = 0;
  for (const wire::Counter& counter : board.counters()) {
    if (counter.name.starts_with("processor.cycles.")) causes += counter.value;
  }
  // Each estimate rounds each of the counters.
  const auto processors = static_cast<double>(v1::AsicConfig().processors());
  EXPECT_NEAR(static_cast<double>(causes), processors * static_cast<double>(board.counter("asic.cycles")),
              40 * 16 * processors);
}

TEST(SampledLevel, KeepsItsIntervalsSumOverAReset) {
  BareBoard board(board_config(100));
  load(board);
  for (int i = 0; i < 40; ++i) board.trace(rays_of(i));
  const std::uint64_t within = board.counter("sampled.cycles_within");
  ASSERT_GT(within, 0u);
  board.write_register(wire::reg::kControl, wire::kControlReset);
  EXPECT_EQ(board.counter("sampled.cycles_within"), within);
  EXPECT_EQ(board.counter("sampled.commands"), 40u);
}

TEST(SampledLevel, NeedsTheCycleLevelAndAnErrorUpToOne) {
  const auto faults = [](unsigned error, v1::FidelityLevel level) {
    std::string text;
    for (const Diagnostic& each : check(resolve(board_config(error, level)))) text += to_string(each) + '\n';
    return text;
  };
  EXPECT_EQ(faults(30, v1::cycle), "");
  EXPECT_EQ(faults(1000, v1::cycle), "");
  EXPECT_THAT(faults(1001, v1::cycle), testing::HasSubstr("sample_error"));
  EXPECT_THAT(faults(30, v1::functional), testing::HasSubstr("sample_error: expected 0 without fidelity=cycle"));
  EXPECT_THAT(faults(30, v1::approximate), testing::HasSubstr("sample_error: expected 0 without fidelity=cycle"));
}

}  // namespace
}  // namespace gicube::emu

// The commands that a machine's memories see.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "bare_board.h"
#include "cycle/machine.h"
#include "machine_rig.h"
#include "rank_checker.h"
#include "rdram_checker.h"

namespace gicube::emu {
namespace {

// Every command that the memories see in a whole frame is legal, by a judge that knows nothing of the controller.
TEST(Machine, AWholeFramesMemoryCommandsAreLegalAndTight) {
  Scene scene({70, 70, 70}, 16);
  scene.fill([](int x, int y, int z) { return wire::Voxel{static_cast<std::uint16_t>(x * y * z % 4096), 0, 0, 0}; });
  for (auto& entry : scene.segmentation) entry.opacity = 500;
  for (const char* sharing : {"rdram.processors_per_rdram=1", "rdram.processors_per_rdram=2"}) {
    const v1::BoardConfig config =
        config_with({"asic.block_voxels=16", "asic.partition=skewed_block", sharing, "rdram.device_mbit=144"});
    Machine machine(config, scene.volume.blocks());
    std::vector<std::vector<rdram::IssuedCommand>> traces(machine.memories().size());
    for (std::size_t i = 0; i < traces.size(); ++i) machine.memories()[i]->channel().set_trace(&traces[i]);
    cycle_picture(scene, corner_view({70, 70, 70}, 64), machine);
    for (std::size_t i = 0; i < traces.size(); ++i) {
      const rdram::ChannelCounters counters = machine.memories()[i]->channel().counters();
      ASSERT_GT(counters.packets_read, 3000u);
      reference::RdramRules rules;
      rules.refresh_interval = config.rdram().refresh_interval();
      rules.devices = machine.memories()[i]->devices();
      rules.refresh_slack = 2 * 32 * 28;  // two processors' packets under way, each of a row of its own: tRC
      const reference::RdramVerdict verdict = reference::check_rdram_trace(rules, traces[i]);
      EXPECT_THAT(verdict.faults, testing::IsEmpty());
      EXPECT_EQ(verdict.data_begins.size(), counters.packets_read);
      EXPECT_GT(verdict.tight_commands, traces[i].size() / 2);
    }
  }
}

TEST(Machine, AWholeFramesDdrCommandsAreLegalAndTight) {
  Scene scene({70, 70, 70}, 16);
  scene.fill([](int x, int y, int z) { return wire::Voxel{static_cast<std::uint16_t>(x * y * z % 4096), 0, 0, 0}; });
  for (auto& entry : scene.segmentation) entry.opacity = 500;
  for (const char* sharing : {"ddr.processors_per_channel=1", "ddr.processors_per_channel=2"}) {
    const v1::BoardConfig config =
        config_with({"memory=ddr", "asic.block_voxels=16", "asic.partition=skewed_block", sharing});
    Machine machine(config, scene.volume.blocks());
    std::vector<std::vector<dram::IssuedCommand>> traces(machine.memories().size());
    for (std::size_t i = 0; i < traces.size(); ++i) machine.memories()[i]->channel().set_trace(&traces[i]);
    cycle_picture(scene, corner_view({70, 70, 70}, 64), machine);
    for (std::size_t i = 0; i < traces.size(); ++i) {
      const dram::ChannelCounters counters = machine.memories()[i]->channel().counters();
      ASSERT_GT(counters.packets_read, 3000u);
      reference::RankRules rules;
      rules.refresh_interval = config.ddr().refresh_interval();
      rules.ranks = machine.memories()[i]->devices();
      const reference::RankVerdict verdict = reference::check_rank_trace(rules, traces[i]);
      EXPECT_THAT(verdict.faults, testing::IsEmpty());
      EXPECT_EQ(verdict.data_begins.size(), counters.packets_read);
      EXPECT_GT(verdict.tight_commands, traces[i].size() / 2);
    }
    std::vector<wire::Counter> counted;
    count(machine, counted);
    const auto reads =
        std::find_if(counted.begin(), counted.end(), [](const auto& c) { return c.name == "ddr.reads"; });
    ASSERT_NE(reads, counted.end());
    EXPECT_GT(reads->value, 3000u);
  }
}

}  // namespace
}  // namespace gicube::emu

// The commands that a machine's memories see.
#include <cstdio>

#include "bare_board.h"
#include "config/energy.h"
#include "cycle/machine.h"
#include "cycle/machine_counters.h"
#include "dram_checkers.h"
#include "machine_rig.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

// Renders a frame on a board of these settings. No command of a channel breaks a rule, by a judge that knows nothing of
// the controller. Returns the machine's counters.
template <typename Rules>
std::vector<wire::Counter> expect_legal_frame(std::vector<std::string> settings, Rules rules) {
  Scene scene({70, 70, 70}, 16);
  scene.fill([](int x, int y, int z) { return wire::Voxel{static_cast<std::uint16_t>(x * y * z % 4096), 0, 0, 0}; });
  for (auto& entry : scene.segmentation) entry.opacity = 500;
  settings.insert(settings.end(), {"asic.block_voxels=16", "asic.partition=skewed_block"});
  Machine machine(config_with(settings), scene.volume.blocks());
  std::vector<std::vector<dram::IssuedCommand>> traces(machine.memories().size());
  for (std::size_t i = 0; i < traces.size(); ++i) machine.memories()[i]->channel().set_trace(&traces[i]);
  cycle_picture(scene, corner_view({70, 70, 70}, 64), machine);
  for (std::size_t i = 0; i < traces.size(); ++i) {
    const dram::ChannelCounters counters = machine.memories()[i]->channel().counters();
    EXPECT_GT(counters.packets_read, 3000u);
    rules.devices = machine.memories()[i]->devices();
    const reference::TraceVerdict verdict = reference::check_trace(rules, traces[i]);
    EXPECT_THAT(verdict.faults, IsEmpty());
    EXPECT_EQ(verdict.data_begins.size(), counters.packets_read);
    EXPECT_GT(verdict.tight_commands, traces[i].size() / 2);
  }
  std::vector<wire::Counter> counted;
  count(machine, counted);
  return counted;
}

TEST(Machine, AWholeFramesRdramCommandsAreLegalAndTight) {
  for (const char* sharing : {"rdram.processors_per_rdram=1", "rdram.processors_per_rdram=2"}) {
    // Two processors' packets are under way, each of a row of its own: tRC.
    expect_legal_frame({sharing, "rdram.device_mbit=144"},
                       reference::RdramRules{.refresh_interval = 781, .refresh_slack = 2 * 32 * 28});
  }
}

TEST(Machine, AWholeFramesDdrCommandsAreLegalAndTight) {
  for (const char* sharing : {"ddr.processors_per_channel=1", "ddr.processors_per_channel=2"}) {
    const auto counted = expect_legal_frame({"memory=ddr", sharing}, reference::RankRules{.refresh_interval = 1562});
    const auto reads = std::ranges::find(counted, "ddr.reads", &wire::Counter::name);
    ASSERT_NE(reads, counted.end());
    EXPECT_GT(reads->value, 3000u);
  }
}

// Joules of memory and memory_interface, as a script counts them from the commands alone.
std::array<double, 2> recounted(const v1::BoardConfig& config, const Machine& machine, Picoseconds now,
                                const std::vector<std::vector<dram::IssuedCommand>>& traces) {
  const reference::TemporaryDirectory folder;
  std::ofstream out(folder.file("commands"));
  int devices = 0;
  for (std::size_t i = 0; i < traces.size(); ++i) {
    devices += static_cast<int>(machine.memories()[i]->devices());
    for (const dram::IssuedCommand& each : traces[i])
      out << i << ' ' << each.device << ' ' << dram::to_string(each.command) << '\n';
  }
  out.close();
  const v1::EnergyConfig& prices = config.energy();
  const std::string command = fmt::format(
      "{} {}/tests/board_emu/cycle/memory_energy.py {} seconds={} clock_khz={} channels={} devices={} standby_uw={} "
      "attention_uw={} activate_fj={} read_fj={} write_fj={} refresh_fj={} io_fj={} interface_uw={}",
      GICUBE_PYTHON, GICUBE_SOURCE_DIR, folder.file("commands"), static_cast<double>(now) * 1e-12,
      config.rdram().clock_khz(), traces.size(), devices, prices.rdram_standby_uw(), prices.rdram_attention_uw(),
      prices.rdram_activate_fj(), prices.rdram_read_fj(), prices.rdram_write_fj(), prices.rdram_refresh_fj(),
      prices.rdram_io_fj(), prices.rdram_interface_uw());
  const std::unique_ptr<FILE, int (*)(FILE*)> script(::popen(command.c_str(), "r"), ::pclose);
  std::array<double, 2> joules{};
  EXPECT_EQ(std::fscanf(script.get(), "%lf %lf", &joules[0], &joules[1]), 2) << command;
  return joules;
}

// Refreshes are priced by the clock, and a channel that nobody asks puts them off: they are left out of the exact
// count.
TEST(Machine, AWholeFramesMemoryEnergyIsThatOfItsCommands) {
  Scene scene({70, 70, 70}, 16);
  scene.fill([](int x, int y, int z) { return wire::Voxel{static_cast<std::uint16_t>(x * y * z % 4096), 0, 0, 0}; });
  for (auto& entry : scene.segmentation) entry.opacity = 500;
  const v1::BoardConfig config =
      config_with({"fidelity=cycle", "asic.block_voxels=16", "asic.max_volume_voxels=128", "rdram.refresh_interval=0"});
  Machine machine(config, scene.volume.blocks());
  std::vector<std::vector<dram::IssuedCommand>> traces(machine.memories().size());
  for (std::size_t i = 0; i < traces.size(); ++i) machine.memories()[i]->channel().set_trace(&traces[i]);
  cycle_picture(scene, corner_view({70, 70, 70}, 64), machine);
  constexpr Picoseconds kNow =
      100'000'000'000;  // later than the frame's end: a picojoule is less than 1e-10 of the sum
  const std::array<double, 2> joules = recounted(config, machine, kNow, traces);
  std::vector<wire::Counter> counted;
  count(machine, counted);
  const std::vector<PartEnergy> parts = EnergyModel(config).parts(counted, kNow);
  for (std::size_t i = 0; i < joules.size(); ++i) {
    const auto part = std::ranges::find(parts, std::string_view(std::array{"memory", "memory_interface"}[i]),
                                        [](const PartEnergy& each) { return std::string_view(each.part); });
    ASSERT_NE(part, parts.end());
    EXPECT_NEAR(static_cast<double>(part->pj) * 1e-12, joules[i], 1e-9 * joules[i]) << part->part;
  }
}

}  // namespace
}  // namespace gicube::emu

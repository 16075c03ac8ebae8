#include "asic/memory_standards.h"

#include <algorithm>

#include "asic/ddr/channel.h"
#include "asic/ddr/layout.h"
#include "asic/rdram/channel.h"
#include "asic/rdram/layout.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {

namespace {

std::uint32_t packets_of_tile(const v1::BoardConfig& config) {
  const auto format = static_cast<wire::VoxelFormat>(config.asic().voxel_format());
  return dram::packets_of_tile(static_cast<std::uint32_t>(wire::voxel_bits(format, config.asic().irradiance_words())));
}

// Packets of a tile that carry irradiance. The second packet takes the words that do not fit into the first.
std::uint32_t written_packets(const v1::BoardConfig& config) { return config.asic().irradiance_words() > 1 ? 2 : 1; }

dram::Standard rdram_standard(const v1::BoardConfig& config) {
  return {.name = "rdram",
          .label = "RDRAM",
          .clock = "tCYCLE",
          .signals = "18 data + 8 row and column + 4 clock + 4 serial",
          .signal_count = 34,
          .sharing = config.rdram().processors_per_rdram(),
          .clock_khz = config.rdram().clock_khz(),
          .latency = config.rdram().rac_latency(),
          .tile_clocks = packets_of_tile(config) * rdram::kPacket,
          .max_devices = 32};  // the most that a channel's controller drives [Direct RDRAM data book]
}

std::unique_ptr<dram::Memory> make_rdram(const v1::BoardConfig& config, std::uint32_t blocks) {
  return std::make_unique<dram::LaidOut<rdram::Layout, rdram::Channel>>(
      rdram::Layout(blocks, config.asic().block_voxels(), config.rdram().device_mbit(), packets_of_tile(config)),
      config.rdram(), written_packets(config));
}

dram::Standard ddr_standard(const v1::BoardConfig& config) {
  return {.name = "ddr",
          .label = "DDR",
          .clock = "clock",
          .signals = "72 data + 9 strobe + 12 address + 2 bank + 4 command + 2 clock + 4 rank select",
          .signal_count = 105,
          .sharing = config.ddr().processors_per_channel(),
          .clock_khz = config.ddr().clock_khz(),
          .latency = config.ddr().controller_latency(),
          .tile_clocks = packets_of_tile(config) * ddr::kBurst,
          .max_devices = 4};  // chosen: two modules of two ranks load the wires as a board of 2000 could bear
}

std::unique_ptr<dram::Memory> make_ddr(const v1::BoardConfig& config, std::uint32_t blocks) {
  return std::make_unique<dram::LaidOut<ddr::Layout, ddr::Channel>>(
      ddr::Layout(blocks, config.asic().block_voxels(), packets_of_tile(config)), config.ddr(),
      written_packets(config));
}

struct Row {
  v1::MemoryStandard memory;
  dram::Standard (*standard)(const v1::BoardConfig& config);
  std::unique_ptr<dram::Memory> (*make)(const v1::BoardConfig& config, std::uint32_t blocks);
};

constexpr Row kRows[] = {{v1::rdram, rdram_standard, make_rdram}, {v1::ddr, ddr_standard, make_ddr}};

// The configuration has been checked. An unknown standard gets the first row.
const Row& row(const v1::BoardConfig& config) {
  const auto* found = std::ranges::find(kRows, config.memory(), &Row::memory);
  return found == std::end(kRows) ? kRows[0] : *found;
}

}  // namespace

dram::Standard memory_standard(const v1::BoardConfig& config) { return row(config).standard(config); }

std::unique_ptr<dram::Memory> make_memory(const v1::BoardConfig& config, std::uint32_t blocks) {
  return row(config).make(config, std::max(1u, blocks));
}

}  // namespace gicube::emu

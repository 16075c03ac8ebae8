#include "asic/ddr/standard.h"

#include "asic/ddr/channel.h"
#include "asic/ddr/layout.h"

namespace gicube::emu::ddr {

dram::Standard standard(const v1::BoardConfig& config) {
  const v1::DdrConfig& ddr = config.ddr();
  dram::Standard out;
  out.name = "ddr";
  out.label = "DDR";
  out.clock = "clock";
  out.signals = "72 data + 9 strobe + 12 address + 2 bank + 4 command + 2 clock + 4 rank select";
  out.signal_count = 105;
  out.sharing = ddr.processors_per_channel();
  out.clocks_per_core_cycle = ddr.clocks_per_core_cycle();
  out.latency = ddr.controller_latency();
  out.packet_clocks = kBurst;
  out.max_devices = 4;  // chosen: two modules of two ranks load the wires as a board of 2000 could bear
  return out;
}

std::unique_ptr<dram::Memory> make_memory(const v1::BoardConfig& config, std::uint32_t blocks) {
  return std::make_unique<dram::LaidOut<Layout, Channel>>(Layout(blocks, config.asic().block_voxels()), config.ddr());
}

std::uint32_t devices_needed(const v1::BoardConfig& config, std::uint32_t blocks) {
  return Layout(blocks, config.asic().block_voxels()).devices();
}

}  // namespace gicube::emu::ddr

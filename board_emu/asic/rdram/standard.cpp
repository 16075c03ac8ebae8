#include "asic/rdram/standard.h"

#include "asic/rdram/channel.h"
#include "asic/rdram/layout.h"

namespace gicube::emu::rdram {

dram::Standard standard(const v1::BoardConfig& config) {
  const v1::RdramConfig& rdram = config.rdram();
  dram::Standard out;
  out.name = "rdram";
  out.label = "RDRAM";
  out.clock = "tCYCLE";
  out.signals = "18 data + 8 row and column + 4 clock + 4 serial";
  out.signal_count = 34;
  out.sharing = rdram.processors_per_rdram();
  out.clocks_per_core_cycle = rdram.clocks_per_core_cycle();
  out.latency = rdram.rac_latency();
  out.packet_clocks = kPacket;
  out.max_devices = 32;  // that the controller of a channel drives [Direct RDRAM data book]
  return out;
}

std::unique_ptr<dram::Memory> make_memory(const v1::BoardConfig& config, std::uint32_t blocks) {
  return std::make_unique<dram::LaidOut<Layout, Channel>>(
      Layout(blocks, config.asic().block_voxels(), config.rdram().device_mbit()), config.rdram());
}

std::uint32_t devices_needed(const v1::BoardConfig& config, std::uint32_t blocks) {
  return devices_needed(blocks, config.asic().block_voxels(), config.rdram().device_mbit());
}

}  // namespace gicube::emu::rdram

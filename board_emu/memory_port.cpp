#include "memory_port.h"

#include <algorithm>
#include <utility>

namespace gicube::emu {

namespace {

Delay delay(rdram::Delay cause) {
  switch (cause) {
    case rdram::Delay::kBank: return Delay::kBank;
    case rdram::Delay::kRefresh: return Delay::kRefresh;
    default: return Delay::kTransfer;
  }
}

}  // namespace

MemoryPort::MemoryPort(const v1::BoardConfig& config, std::vector<MissQueue*> misses, std::size_t blocks)
    : misses_(std::move(misses)),
      layout_(static_cast<std::uint32_t>(std::max<std::size_t>(1, blocks * misses_.size())),
              config.asic().block_voxels(), config.rdram().device_mbit()),
      channel_(config.rdram(), layout_.devices()),
      ratio_(config.rdram().clocks_per_core_cycle()),
      rac_latency_(config.rdram().rac_latency()) {}

// Serves the processor whose turn it is, or the next that has a request.
bool MemoryPort::serve(Cycle now) {
  for (std::size_t i = 0; i < misses_.size(); ++i) {
    const std::size_t which = turn_ + i < misses_.size() ? turn_ + i : turn_ + i - misses_.size();
    MissQueue& queue = *misses_[which];
    if (!queue.can_send(now)) continue;
    const Packet& packet = queue.next();
    // The blocks of two processors lie in turn in the memory that they share.
    const auto block = packet.block * static_cast<std::uint32_t>(misses_.size()) + static_cast<std::uint32_t>(which);
    const rdram::Access access = channel_.read(layout_.locate(block, packet.tile), now * ratio_);
    const std::uint64_t arrival = access.data_end + rac_latency_;
    queue.send(now, (arrival + ratio_ - 1) / ratio_, delay(access.cause));
    turn_ = which + 1 < misses_.size() ? which + 1 : 0;
    return true;
  }
  return false;
}

}  // namespace gicube::emu

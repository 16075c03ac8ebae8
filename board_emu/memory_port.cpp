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

inline void MemoryPort::send(std::size_t which, Cycle now) {
  MissQueue& queue = *misses_[which];
  const Packet& packet = queue.next();
  // The blocks of two processors lie in turn in the memory that they share.
  const auto block = packet.block * static_cast<std::uint32_t>(misses_.size()) + static_cast<std::uint32_t>(which);
  const rdram::Access access = channel_.read(layout_.locate(block, packet.tile), now * ratio_);
  const std::uint64_t arrival = access.data_end + rac_latency_;
  queue.send(now, (arrival + ratio_ - 1) / ratio_, delay(access.cause));
  latest_ = now;
}

// Serves the processor whose turn it is, or the next that has a request.
bool MemoryPort::serve(Cycle now) {
  for (std::size_t i = 0; i < misses_.size(); ++i) {
    const std::size_t which = turn_ + i < misses_.size() ? turn_ + i : turn_ + i - misses_.size();
    if (!misses_[which]->can_send(now)) continue;
    send(which, now);
    turn_ = which + 1 < misses_.size() ? which + 1 : 0;
    return true;
  }
  return false;
}

bool MemoryPort::serve_ahead() {
  const MissQueue& queue = *misses_.front();
  while (!queue.all_sent()) send(0, std::max(queue.next().asked, latest_) + 1);
  return true;
}

}  // namespace gicube::emu

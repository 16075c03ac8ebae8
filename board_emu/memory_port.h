// One RDRAM channel and the processors that it serves, one or two [P §3.3]: sends their requests on, one a core cycle,
// in turn, and tells them when each packet arrives.
#pragma once

#include <cstdint>
#include <vector>

#include "cache/miss_queue.h"
#include "gicube/v1/board_config.pb.h"
#include "rdram/channel.h"
#include "rdram/layout.h"

namespace gicube::emu {

class MemoryPort {
 public:
  // `misses`: of the processors, in their order. `blocks`: the most that any of them holds.
  MemoryPort(const v1::BoardConfig& config, std::vector<MissQueue*> misses, std::size_t blocks);

  bool tick(Cycle now) {
    for (const MissQueue* queue : misses_) {
      if (queue->can_send(now)) return serve(now);
    }
    return false;
  }

  std::uint64_t cycles(Cycle now) const { return now * ratio_; }  // tCYCLE until then
  std::uint32_t devices() const { return layout_.devices(); }
  const rdram::Channel& channel() const { return channel_; }
  rdram::Channel& channel() { return channel_; }

 private:
  bool serve(Cycle now);

  std::vector<MissQueue*> misses_;
  rdram::Layout layout_;
  rdram::Channel channel_;
  std::uint64_t ratio_;  // tCYCLE a core cycle
  std::uint64_t rac_latency_;
  std::size_t turn_ = 0;
};

}  // namespace gicube::emu

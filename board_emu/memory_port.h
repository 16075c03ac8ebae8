// One RDRAM channel and the processors that it serves, one or two [P §3.3]: sends their requests on, one a core cycle,
// in turn, and tells them when each packet arrives.
//
// A processor that has its channel to itself can be told at once: nobody else's requests come between.
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
  // The same, or all that was asked for so far, each in the cycle in which it will be sent: to be called in every cycle
  // too. What has been counted may then be ahead of the cycle.
  bool tick_ahead(Cycle now) {
    if (misses_.size() > 1) return tick(now);
    return !misses_.front()->all_sent() && serve_ahead();
  }

  std::uint64_t cycles(Cycle now) const { return now * ratio_; }  // tCYCLE until then
  std::uint32_t devices() const { return layout_.devices(); }
  const rdram::Channel& channel() const { return channel_; }
  rdram::Channel& channel() { return channel_; }

 private:
  bool serve(Cycle now);
  bool serve_ahead();
  void send(std::size_t which, Cycle now);

  std::vector<MissQueue*> misses_;
  rdram::Layout layout_;
  rdram::Channel channel_;
  std::uint64_t ratio_;  // tCYCLE a core cycle
  std::uint64_t rac_latency_;
  std::size_t turn_ = 0;
  Cycle latest_ = 0;  // in which something was sent
};

}  // namespace gicube::emu

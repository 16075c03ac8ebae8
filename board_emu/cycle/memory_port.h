// One memory channel and the one or two processors that it serves [P §3.3]: sends their requests on in turn, one per
// core cycle, and reports when each packet arrives [H322].
//
// If only one processor uses the channel, arrival times can be computed at once, because no other requests intervene.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "asic/cache/miss_queue.h"
#include "asic/cache/write_queue.h"
#include "asic/memory_standards.h"
#include "gicube/v1/board_config.pb.h"
#include "words/clock.h"

namespace gicube::emu {

// Requests of one processor. Its reads and writes are served in the order of the requests, a read before a write of the
// same cycle.
struct MemoryClient {
  MissQueue* misses;
  WriteQueue* writes;

  bool all_sent() const { return misses->all_sent() && writes->all_sent(); }
  bool next_is_write() const {
    return !writes->all_sent() && (misses->all_sent() || writes->next().asked < misses->next().asked);
  }
  Cycle next_asked() const { return next_is_write() ? writes->next().asked : misses->next().asked; }
  bool can_send(Cycle now) const { return !all_sent() && next_asked() < now; }
};

class MemoryPort {
 public:
  // `clients`: the processors, in their order. `blocks`: the most blocks that any of them holds.
  MemoryPort(const v1::BoardConfig& config, std::vector<MemoryClient> clients, std::size_t blocks);

  bool tick(Cycle now) {
    if (now <= latest_) return false;  // a request of this cycle was sent ahead
    for (const MemoryClient& client : clients_) {
      if (client.can_send(now)) return serve(now);
    }
    return false;
  }
  // Like tick(), and called as often, but may send all waiting requests at once, each for its own later cycle. The
  // counters may then be ahead of the cycle.
  bool tick_ahead(Cycle now) {
    if (clients_.size() > 1) return tick(now);
    return !clients_.front().all_sent() && serve_ahead();
  }

  // Requests a tile of a block for the only client, whose requests were all sent, and sends the request as tick_ahead()
  // would.
  void fetch(Cycle now, std::uint32_t block, std::uint32_t tile) {
    latest_ = std::max(now, latest_) + 1;
    const Answer answer = read(block, tile, latest_);
    clients_.front().misses->ask({block, tile, now, latest_, answer.arrival, answer.delay});
  }

  std::uint64_t cycles(Cycle now) const { return to_memory_.passed(now); }  // cycles of the memory's clock
  std::uint32_t devices() const { return channel_->devices(); }
  const dram::Memory& channel() const { return *channel_; }
  dram::Memory& channel() { return *channel_; }
  Cycle latest() const { return latest_; }  // last cycle in which something was sent
  void state(Archive& archive) {
    archive.in_clock(cycles(archive.latest()), [&] { archive("channel", *channel_); });
    archive.at_most("turn", turn_, clients_.size() - 1);
    archive("latest", latest_);
  }

 private:
  // The blocks of two processors alternate in their shared memory.
  std::uint32_t block_in_memory(std::uint32_t block, std::size_t which) const {
    return block * static_cast<std::uint32_t>(clients_.size()) + static_cast<std::uint32_t>(which);
  }
  bool serve(Cycle now);
  bool serve_ahead();
  void send(std::size_t which, Cycle now);
  struct Answer {
    Cycle arrival;
    Delay delay;
  };
  // Reads a packet whose request is sent at `now`; `block`: in memory.
  Answer read(std::uint32_t block, std::uint32_t tile, Cycle now) {
    const dram::Access access = channel_->read(block, tile, to_memory_.from(now));
    return {to_core_.from(access.data_end + latency_), access.cause};
  }

  std::vector<MemoryClient> clients_;
  std::unique_ptr<dram::Memory> channel_;
  ClockRatio to_memory_, to_core_;
  std::uint32_t latency_;
  std::size_t turn_ = 0;
  Cycle latest_ = 0;  // last cycle in which something was sent
};

}  // namespace gicube::emu

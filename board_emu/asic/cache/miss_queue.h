// Packets that a processor has requested from its memory and not yet written into its cache, oldest first [P §3.3].
//
// The pipeline requests packets and takes them; the memory port sends the requests in order and records when each
// packet arrives. A request can be sent from the next cycle on, so the order in which the two sides tick does not
// matter [H313].
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "asic/sim/causes.h"
#include "gicube/archive.h"
#include "words/clock.h"

namespace gicube::emu {

struct Packet {
  std::uint32_t block = 0;  // number of the block in its processor
  std::uint32_t tile = 0;
  Cycle asked = 0;
  Cycle sent = kNoCycle;     // when the memory accepted it
  Cycle arrival = kNoCycle;  // from this cycle on it can be written into the cache
  Delay delay = Delay::kTransfer;

  void state(Archive::Record& record) {
    record(block, tile);
    record.times(asked, sent, arrival);
    record.at_most(delay, Delay::kRefresh);
  }
};

class MissQueue {
 public:
  explicit MissQueue(std::size_t packets) : ring_(std::bit_ceil(packets)), mask_(ring_.size() - 1), packets_(packets) {}

  std::size_t room() const { return packets_ - size_; }
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }

  void ask(Cycle now, std::uint32_t block, std::uint32_t tile) {
    ring_[(head_ + size_) & mask_] = {block, tile, now, kNoCycle, kNoCycle, Delay::kTransfer};
    ++size_;
  }
  // Adds a packet whose request is sent at once. All earlier requests must have been sent.
  void ask(const Packet& sent) {
    ring_[(head_ + size_) & mask_] = sent;
    ++size_;
    ++sent_;
  }
  const Packet& oldest() const { return ring_[head_ & mask_]; }
  void take() {
    ++head_;
    --size_;
    --sent_;
  }

  bool all_sent() const { return sent_ == size_; }
  bool can_send(Cycle now) const { return !all_sent() && next().asked < now; }
  const Packet& next() const { return ring_[(head_ + sent_) & mask_]; }
  void send(Cycle now, Cycle arrival, Delay delay) {
    Packet& packet = ring_[(head_ + sent_) & mask_];
    packet.sent = now;
    packet.arrival = arrival;
    packet.delay = delay;
    ++sent_;
  }
  Cycle latest_asked() const {
    Cycle latest = 0;
    for (std::size_t i = 0; i < size_; ++i) latest = std::max(latest, ring_[(head_ + i) & mask_].asked);
    return latest;
  }
  // `blocks`: those of the processor. `tiles`: those of a block.
  void state(Archive::Record& record, std::uint32_t blocks, std::size_t tiles) {
    record.at_most(size_, packets_);
    record.at_most(sent_, size_);
    for (std::size_t i = 0; i < size_; ++i) {
      Packet& packet = ring_[(head_ + i) & mask_];
      record(packet);
      record.expect(packet.block < blocks && packet.tile < tiles, "tiles of its blocks", packet.tile);
    }
  }

 private:
  std::vector<Packet> ring_;  // its size is a power of two
  std::size_t mask_;
  std::size_t packets_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
  std::size_t sent_ = 0;
};

}  // namespace gicube::emu

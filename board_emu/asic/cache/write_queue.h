// Packets on their way from a processor's volume cache to its memory: tiles whose irradiance has changed [P §3.4].
//
// Writes wait here until there are enough of them to amortise a bus turnaround. A tile that changes again while it
// waits is written once, except with write_through. With write_back a tile enters the queue when the cache evicts it. A
// tile that is no longer in the cache is fetched first. The memory serves writes and the reads of misses in the order
// of the requests. A read of a tile that still waits here takes as long as one from memory [H964, H965].
#pragma once

#include <algorithm>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gicube/archive.h"
#include "words/clock.h"

namespace gicube::emu {

struct TileWrite {
  std::uint32_t block = 0;  // number of the block in its processor
  std::uint32_t tile = 0;
  bool fetch = false;  // a read that precedes the write
  Cycle asked = 0;
  Cycle sent = kNoCycle;  // when the memory accepted it

  void state(Archive::Record& record) {
    record(block, tile, fetch);
    record.times(asked, sent);
  }
};

struct WriteCounters {
  std::uint64_t tiles = 0;     // changes of tiles
  std::uint64_t combined = 0;  // changes that are written together with an earlier one
  std::uint64_t fetches = 0;   // changes of tiles that were no longer in the cache

  void state(Archive::Record& record) { record(tiles, combined, fetches); }
};

class WriteQueue {
 public:
  // `tiles`: capacity. Requests are made once half of it is taken.
  explicit WriteQueue(std::size_t tiles) : capacity_(tiles) {}

  std::size_t room() const { return capacity_ - std::min(capacity_, size()); }
  bool empty() const { return size() == 0; }
  std::size_t size() const { return end_ - first_; }

  // Adds a changed tile. If `combines`, a waiting write of the same tile absorbs it.
  void put(std::uint32_t block, std::uint32_t tile, bool in_cache, bool combines = true) {
    ++counters_.tiles;
    if (combines && waits(block, tile)) {
      ++counters_.combined;
      return;
    }
    add(block, tile, in_cache);
  }
  // Counts a change of a tile that stays in the cache and is written later. `is_first`: its first change since it was
  // written.
  void change(bool is_first) {
    ++counters_.tiles;
    counters_.combined += is_first ? 0 : 1;
  }
  // Adds the read of a tile that is about to change in the cache.
  void fetch(std::uint32_t block, std::uint32_t tile) {
    ++counters_.fetches;
    push({block, tile, true, 0, kNoCycle});
  }
  // Adds the write of an evicted changed tile.
  void write_back(std::uint32_t block, std::uint32_t tile) {
    if (waits(block, tile)) {
      ++counters_.combined;
    } else {
      add(block, tile, true);
    }
  }
  // Requests all waiting writes if they fill half of the queue, or if `all`.
  void ask(Cycle now, bool all) {
    if (waiting_ == end_ || (!all && 2 * (end_ - waiting_) < capacity_)) return;
    for (; waiting_ != end_; ++waiting_) at(waiting_).asked = now;
    maybe_waits_.reset();
  }

  // Frees the entries that were sent before `now`. The processor calls it, so that the order in which the two sides
  // tick does not matter.
  void settle(Cycle now) {
    while (first_ != next_ && at(first_).sent < now) ++first_;
  }

  bool all_sent() const { return next_ == waiting_; }
  const TileWrite& next() const { return at(next_); }
  void send(Cycle now) { at(next_++).sent = now; }
  const WriteCounters& counters() const { return counters_; }
  Cycle latest_asked() const { return first_ == waiting_ ? 0 : at(waiting_ - 1).asked; }
  // `blocks`: those of the processor. `tiles`: those of a block.
  void state(Archive& archive, std::uint32_t blocks, std::size_t tiles) {
    archive.expect_idle(empty(), "the queue of writes");
    archive("counters", counters_);
    if (!archive.in_run()) return;
    std::vector<TileWrite> asked, waiting;
    for (std::size_t i = first_; i != end_; ++i) (i < waiting_ ? asked : waiting).push_back(at(i));
    std::size_t sent = next_ - first_;
    archive.list("waiting", waiting);
    archive.list("asked", asked);
    archive.at_most("sent", sent, asked.size());
    first_ = end_ = 0;
    for (const auto* const writes : {&asked, &waiting}) {
      for (const TileWrite& write : *writes) {
        archive.expect(write.block < blocks && write.tile < tiles, "asked", "tiles of its blocks", write.tile);
        push(write);
      }
    }
    next_ = sent;
    waiting_ = asked.size();
  }

 private:
  static constexpr std::size_t kFilter = 1024;  // bits; chosen so that two waiting tiles rarely share one

  TileWrite& at(std::size_t number) { return ring_[number & (ring_.size() - 1)]; }
  const TileWrite& at(std::size_t number) const { return ring_[number & (ring_.size() - 1)]; }
  static std::size_t bit_of(std::uint32_t block, std::uint32_t tile) { return (tile ^ block * 401) % kFilter; }

  bool waits(std::uint32_t block, std::uint32_t tile) const {
    if (!maybe_waits_[bit_of(block, tile)]) return false;
    for (std::size_t i = waiting_; i != end_; ++i) {
      if (at(i).block == block && at(i).tile == tile) return true;
    }
    return false;
  }
  void add(std::uint32_t block, std::uint32_t tile, bool in_cache) {
    if (!in_cache) fetch(block, tile);
    push({block, tile, false, 0, kNoCycle});
  }
  void push(const TileWrite& write) {
    if (size() == ring_.size()) {
      std::vector<TileWrite> larger(2 * size());
      for (std::size_t i = first_; i != end_; ++i) larger[i & (larger.size() - 1)] = at(i);
      ring_.swap(larger);
    }
    at(end_++) = write;
    maybe_waits_.set(bit_of(write.block, write.tile));
  }

  std::size_t capacity_;
  std::vector<TileWrite> ring_ = std::vector<TileWrite>(1);  // its size is a power of two
  // Running numbers of writes: the oldest entry, the first that is not sent, the first that is not requested, and the
  // next to be added.
  std::size_t first_ = 0, next_ = 0, waiting_ = 0, end_ = 0;
  std::bitset<kFilter> maybe_waits_;
  WriteCounters counters_;
};

}  // namespace gicube::emu

// Packets on their way from a processor's volume cache to its memory: tiles whose irradiance has changed [P §3.4].
//
// Writes wait here until there are enough of them to be worth turning the memory's bus round; a tile that changes again
// while it waits is written once, unless each change is to be written (write_through). With write_back tiles come here when their
// place in the cache goes to another. A tile that the cache has lost in the meantime is fetched first. The memory serves writes
// and the misses' reads in the order in which they were asked for; a read of a tile that still waits here takes no longer
// than one from memory.
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
  bool fetch = false;  // a read that goes before the write
  Cycle asked = 0;
  Cycle sent = kNoCycle;  // when the memory took it on

  void state(Archive::Record& record) {
    record(block, tile, fetch);
    record.times(asked, sent);
  }
};

struct WriteCounters {
  std::uint64_t tiles = 0;     // that changed
  std::uint64_t combined = 0;  // of them, written with an earlier change
  std::uint64_t fetches = 0;   // of them, no longer in the cache

  void state(Archive::Record& record) { record(tiles, combined, fetches); }
};

class WriteQueue {
 public:
  // Tiles that may wait; asked for once half of the places are taken.
  explicit WriteQueue(std::size_t tiles) : places_(tiles) {}

  std::size_t room() const { return places_ - std::min(places_, size()); }
  bool empty() const { return size() == 0; }
  std::size_t size() const { return end_ - first_; }

  // A tile has changed: it is written with an earlier change that still waits, if `combines`.
  void put(std::uint32_t block, std::uint32_t tile, bool in_cache, bool combines = true) {
    ++counters_.tiles;
    if (combines && waits(block, tile)) {
      ++counters_.combined;
      return;
    }
    add(block, tile, in_cache);
  }
  // A tile has changed in the cache, from which it is written later; `anew`: it had not before.
  void change(bool anew) {
    ++counters_.tiles;
    counters_.combined += anew ? 0 : 1;
  }
  // It is read before it is changed there.
  void fetch(std::uint32_t block, std::uint32_t tile) {
    ++counters_.fetches;
    push({block, tile, true, 0, kNoCycle});
  }
  // That is now.
  void write_back(std::uint32_t block, std::uint32_t tile) {
    if (waits(block, tile)) {
      ++counters_.combined;
    } else {
      add(block, tile, true);
    }
  }
  // Asks for what waits, if it is time to.
  void ask(Cycle now, bool all) {
    if (waiting_ == end_ || (!all && 2 * (end_ - waiting_) < places_)) return;
    for (; waiting_ != end_; ++waiting_) at(waiting_).asked = now;
    maybe_waits_.reset();
  }

  // Gives the places of what was sent before `now` free: for the processor to call, so that it does not matter which side
  // ticks first.
  void settle(Cycle now) {
    while (first_ != next_ && at(first_).sent < now) ++first_;
  }

  bool all_sent() const { return next_ == waiting_; }
  const TileWrite& next() const { return at(next_); }
  void send(Cycle now) { at(next_++).sent = now; }
  const WriteCounters& counters() const { return counters_; }
  Cycle latest_asked() const { return first_ == waiting_ ? 0 : at(waiting_ - 1).asked; }
  // Of a processor with `blocks` of `tiles`.
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
  static constexpr std::size_t kFilter = 1024;  // bits: so many that two of the tiles that wait rarely have the same

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

  std::size_t places_;
  std::vector<TileWrite> ring_ = std::vector<TileWrite>(1);  // as large as a power of two
  // Numbers of writes there: of the first whose place is taken, the first that is not sent, the first that is not asked for, and
  // the next.
  std::size_t first_ = 0, next_ = 0, waiting_ = 0, end_ = 0;
  std::bitset<kFilter> maybe_waits_;
  WriteCounters counters_;
};

}  // namespace gicube::emu

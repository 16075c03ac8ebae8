// Packets on their way from a processor's volume cache to its memory: tiles whose irradiance has changed [P §3.4].
//
// Writes wait here until there are enough of them to be worth turning the memory's bus round; a tile that changes again
// while it waits is written once, unless each change is to be written (write_through). With write_back tiles come here when their
// place in the cache goes to another. A tile that the cache has lost in the meantime is fetched first. The memory serves writes
// and the misses' reads in the order in which they were asked for; a read of a tile that still waits here takes no longer
// than one from memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "gicube/archive.h"
#include "words/clock.h"

namespace gicube::emu {

struct TileWrite {
  std::uint32_t block = 0;  // number of the block in its processor
  std::uint32_t tile = 0;
  bool fetch = false;  // a read that goes before the write
  Cycle asked = 0;
  Cycle sent = kNoCycle;  // when the memory took it on

  void state(Archive::Record& record) { record(block, tile, fetch, asked, sent); }
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

  std::size_t room() const { return places_ - std::min(places_, waiting_.size() + asked_.size()); }
  bool empty() const { return waiting_.empty() && asked_.empty(); }
  std::size_t size() const { return waiting_.size() + asked_.size(); }

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
    waiting_.push_back({block, tile, true, 0, kNoCycle});
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
    if (waiting_.empty() || (!all && 2 * waiting_.size() < places_)) return;
    for (TileWrite& write : waiting_) {
      write.asked = now;
      asked_.push_back(write);
    }
    waiting_.clear();
  }

  // Gives the places of what was sent before `now` free: for the processor to call, so that it does not matter which side
  // ticks first.
  void settle(Cycle now) {
    while (sent_ > 0 && asked_.front().sent < now) {
      asked_.pop_front();
      --sent_;
    }
  }

  bool all_sent() const { return sent_ == asked_.size(); }
  const TileWrite& next() const { return asked_[sent_]; }
  void send(Cycle now) { asked_[sent_++].sent = now; }
  const WriteCounters& counters() const { return counters_; }
  Cycle latest_asked() const {
    Cycle latest = 0;
    for (const TileWrite& write : asked_) latest = std::max(latest, write.asked);
    return latest;
  }
  // Of a processor with `blocks` of `tiles`.
  void state(Archive& archive, std::uint32_t blocks, std::size_t tiles) {
    archive.expect_idle(empty(), "the queue of writes");
    archive("counters", counters_);
    if (!archive.in_run()) return;
    archive.list("waiting", waiting_);
    archive.list("asked", asked_);
    archive.at_most("sent", sent_, asked_.size());
    for (const auto* const writes : {&waiting_, &asked_}) {
      for (const TileWrite& write : *writes) {
        archive.expect(write.block < blocks && write.tile < tiles, "asked", "tiles of its blocks", write.tile);
      }
    }
  }

 private:
  bool waits(std::uint32_t block, std::uint32_t tile) const {
    return std::any_of(waiting_.begin(), waiting_.end(),
                       [=](const TileWrite& write) { return write.block == block && write.tile == tile; });
  }
  void add(std::uint32_t block, std::uint32_t tile, bool in_cache) {
    if (!in_cache) {
      ++counters_.fetches;
      waiting_.push_back({block, tile, true, 0, kNoCycle});
    }
    waiting_.push_back({block, tile, false, 0, kNoCycle});
  }

  std::size_t places_;
  std::deque<TileWrite> waiting_;
  std::deque<TileWrite> asked_;
  std::size_t sent_ = 0;  // of them
  WriteCounters counters_;
};

}  // namespace gicube::emu

// A processor's write queue (asic/cache/write_queue.h) in tiles instead of cycles: what waits in it, what it has asked the memory for,
// and when that leaves it. A tile that is fetched first takes no place more.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "asic/cache/write_queue.h"
#include "gicube/archive.h"
#include "pass_queue.h"
#include "words/clock.h"

namespace gicube::emu {

class PassWrites {
 public:
  static constexpr std::size_t kSplatPlaces = 16;  // eight tiles, each fetched first

  explicit PassWrites(std::size_t places) : places_(places) {}

  // No write is under way, and all that were are long gone.
  void begin() { leaving_.clear(); }

  // A tile changes in cycle `now`, which is never before that of the last call. `block`: its number in the processor.
  // Whether the cache still has it then is not known yet: lost_before() tells.
  void put(std::uint32_t block, std::uint32_t tile, bool combines, Cycle now) {
    ++counters_.tiles;
    changed_ = now;
    const auto waits = [=](const TileWrite& write) { return write.block == block && write.tile == tile; };
    if (combines && std::any_of(waiting_.begin(), waiting_.end(), waits)) {
      ++counters_.combined;
      return;
    }
    waiting_.push_back({block, tile});
    changes_.push({block, tile, false, now});
  }
  // Calls fetch(write) for each tile that changed before cycle `now` and that holds(write) says is no longer in the cache.
  template <typename Holds, typename Fetch>
  void lost_before(Cycle now, const Holds& holds, const Fetch& fetch) {
    for (; !changes_.empty() && changes_.front().asked < now; changes_.drop()) {
      if (holds(changes_.front())) continue;
      ++counters_.fetches;
      fetch(changes_.front());
    }
  }

  // The first cycle from `now` on in which a splat finds its places.
  Cycle room_from(Cycle now) {
    if (now > changed_ && 2 * waiting_.size() >= places_) ask(changed_ + 1);
    while (waiting_.size() + leaving_.size() + kSplatPlaces > places_) {
      if (leaving_.empty()) ask(std::max(now, changed_ + 1));
      now = std::max(now, leaving_.pop() + 1);
    }
    while (!leaving_.empty() && leaving_.front() < now) leaving_.drop();
    return now;
  }

  // Asks in cycle `now` for all that waits: nothing is in the pipeline.
  void ask(Cycle now) {
    for (TileWrite& write : waiting_) {
      write.asked = now;
      left_ = std::max(left_, now) + 1;  // one a cycle, unless reads come between
      leaving_.push(left_);
      asked_.push(write);
    }
    waiting_.clear();
  }
  bool empty() const { return waiting_.empty() && asked_.empty(); }

  // Calls send(write) for what was asked for before cycle `now`, in its order.
  template <typename Send>
  void send_before(Cycle now, const Send& send) {
    for (; !asked_.empty() && asked_.front().asked < now; asked_.drop()) send(asked_.front());
  }

  Cycle changed() const { return changed_; }
  const WriteCounters& counters() const { return counters_; }
  void state(Archive::Record& record) { record(counters_, changed_, left_); }

 private:
  std::size_t places_;
  std::vector<TileWrite> waiting_;
  LongQueue<TileWrite> asked_;
  LongQueue<TileWrite> changes_;  // `asked`: when
  LongQueue<Cycle> leaving_;      // of what was asked for: when it leaves its place
  Cycle left_ = 0, changed_ = 0;
  WriteCounters counters_;
};

}  // namespace gicube::emu

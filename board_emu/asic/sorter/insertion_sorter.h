// The pipelined insertion sorter that finds the most important queue [P §3.2, Figure 7].
//
// One rank a queue; rank 0 is the top. A rank has two buffers, selected and comparison, each an item (queue and
// importance) or a hole. Each cycle every rank compares its two: the larger goes to its selected buffer, the smaller to
// the comparison buffer of the rank below; a hole takes whatever comes. Equal importance: the lower queue number counts
// as larger [C], so that the settled order does not depend on history. The active queue is in rank 0 with infinite
// importance.
//
//   insert --> [comparison 0] [selected 0]      rank 0
//                    |  smaller
//              [comparison 1] [selected 1]      rank 1      shift_up: both buffers of every rank move up by one
//
// Exactly the machine above, but comparisons are made late and many at a time. Items in comparison buffers move down
// together, one rank a cycle, so none catches up with another, and only the older of two may leave something for the
// younger to find: one after the other, oldest first, each can go down all its ranks at once, its key in a register.
// That is done when it matters: for rank 0 at once, for a rank whose queue is wiped before that, and for all now and
// then. Ranks are kept at positions that do not change: shift_up moves only the origin.
#pragma once

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdint>
#include <vector>

#include "gicube/archive.h"

namespace gicube::emu {

class InsertionSorter {
 public:
  static constexpr std::uint32_t kNoQueue = ~std::uint32_t{0};
  static constexpr std::uint32_t kInfinite = ~std::uint32_t{0};

  explicit InsertionSorter(std::uint32_t queues);

  // One cycle: every rank compares.
  void step() {
    if (moving_.empty()) return;
    ++steps_;
    if (entering_) {
      entering_ = false;
      move_down(moving_.back(), origin_ + 1);
    }
    if (++behind_ == kMaxBehind) catch_up();
  }

  // Whether the top's comparison buffer is free: one insert a cycle, and none where shift_up has filled it.
  bool can_insert() const { return !entering_; }
  // Puts a queue's new importance (1 .. kInfinite - 1) into the top's comparison buffer and wipes it where it was.
  void insert(std::uint32_t queue, std::uint32_t importance);

  // The queue in the top's selected buffer, or kNoQueue: a hole's lower half is no queue's number.
  std::uint32_t top() const { return queue_of(selected_[origin_]); }
  // The top's queue becomes active: its importance is infinite from now on.
  void activate_top() {
    assert(top() != kNoQueue);
    selected_[origin_] = key(top(), kInfinite);
  }

  // All ranks move up by one; what is in the top's selected buffer leaves. Its comparison buffer must be empty.
  void shift_up();

  // Whether the queue's item is in some buffer.
  bool has(std::uint32_t queue) const { return inserted_[queue] != kHole; }
  // Items in both kinds of buffers, the active queue among them.
  std::uint32_t size() const { return size_; }

  struct Item {
    std::uint32_t queue = kNoQueue;
    std::uint32_t importance = 0;
    friend bool operator==(const Item&, const Item&) = default;
  };
  // What a rank's buffers hold and whether any comparison buffer holds something, for tests: slow.
  Item selected(std::uint32_t rank) const { return item(caught_up().selected_[origin_ + rank]); }
  Item comparison(std::uint32_t rank) const {
    for (const Moving& moving : caught_up().moving_) {
      if (moving.at == origin_ + rank) return item(moving.key);
    }
    return {};
  }
  bool moving() const { return !caught_up().moving_.empty(); }

  void state(Archive& archive);

 private:
  // Importance above, complement of the queue number below: keys compare as items do.
  using Key = std::uint64_t;
  static constexpr Key kHole = 0;
  // chosen: long enough that starting on an item costs little against its comparisons, short enough for few items.
  static constexpr std::uint32_t kMaxBehind = 10;

  // An item in a comparison buffer, or what it pushed down in its place.
  struct Moving {
    Key key = kHole;         // kHole once it has found its place or was wiped
    std::uint32_t at = 0;    // position of the first comparison not yet made
    std::uint32_t slot = 0;  // position minus steps: where it is by now is slot + steps_

    void state(Archive::Record& record) { record(key, at); }
  };

  static Key key(std::uint32_t queue, std::uint32_t importance) { return Key{importance} << 32 | ~queue; }
  static std::uint32_t queue_of(Key key) { return ~static_cast<std::uint32_t>(key); }
  static Item item(Key key) {
    return key == kHole ? Item{} : Item{queue_of(key), static_cast<std::uint32_t>(key >> 32)};
  }

  // Makes an item's comparisons above position `to`; those of all older items must have been made.
  void move_down(Moving& item, std::uint32_t to) {
    Key* const selected = selected_.data();
    Key carried = item.key;
    std::size_t at = item.at;  // as wide as an address, or each comparison would begin by widening it
    item.at = to;
    if (carried == kHole) return;
    while (at != to && carried < selected[at]) ++at;  // first it passes larger ones, then it pushes smaller ones down
    for (; at != to; ++at) {
      const Key here = selected[at];
      if (carried < here) continue;
      selected[at] = carried;
      carried = here;
      if (here == kHole) break;
    }
    item.key = carried;
  }
  // All items' comparisons above a position, as far as their time has come.
  void catch_up_to(std::uint32_t position);
  // All comparisons; items that need no more of them are forgotten.
  void catch_up();
  InsertionSorter caught_up() const {
    InsertionSorter copy = *this;
    copy.catch_up();
    return copy;
  }
  // Makes a hole where an item is.
  void wipe(Key key);
  // Moves everything back to position 0.
  void begin_anew();

  std::uint32_t ranks_;
  std::uint32_t origin_ = 0;  // position of rank 0; up to ranks_
  std::uint32_t steps_ = 0;   // cycles with items in motion
  std::uint32_t behind_ = 0;  // of them, since all comparisons were made
  std::uint32_t size_ = 0;
  bool entering_ = false;       // rank 0's comparison buffer is full, with moving_'s last
  std::vector<Key> selected_;   // by position
  std::vector<Key> inserted_;   // by queue: its item, or kHole; its place changes far more often than it is asked
  std::vector<Moving> moving_;  // oldest first, so from the lowest rank up
};

// The most important of all queues, known at once: the bound that a perfect sorter would reach [C]. A tree of winners over
// the queues' importances. Equal ones: the lower queue number wins.
class ExactMaximum {
 public:
  explicit ExactMaximum(std::uint32_t queues) : leaves_(std::bit_ceil(queues)), importance_(2 * std::size_t{leaves_}) {}

  void set(std::uint32_t queue, std::uint32_t importance) {
    std::uint32_t node = leaves_ + queue;
    importance_[node] = importance;
    while (node > 1) {
      node /= 2;
      const std::uint32_t larger = std::max(importance_[2 * node], importance_[2 * node + 1]);
      if (importance_[node] == larger) return;
      importance_[node] = larger;
    }
  }

  // The largest; 0 if there is none.
  std::uint32_t importance() const { return importance_[1]; }
  // Only if some importance is above 0.
  std::uint32_t queue() const {
    std::uint32_t node = 1;
    while (node < leaves_) node = 2 * node + (importance_[2 * node] == importance_[node] ? 0 : 1);
    return node - leaves_;
  }
  // Between runs no queue has rays.
  void state(Archive& archive) { archive.expect_idle(importance() == 0, "the sorter"); }

 private:
  std::uint32_t leaves_;
  std::vector<std::uint32_t> importance_;  // node 1 is the root
};

}  // namespace gicube::emu

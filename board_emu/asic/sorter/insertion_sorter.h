// The pipelined insertion sorter that finds the most important queue [P §3.2, Figure 7].
//
// There is one rank per queue; rank 0 is the top. A rank has two buffers, selected and comparison, each an item (queue
// and importance) or a hole. Each cycle every rank compares its two: the larger goes to its selected buffer, the
// smaller to the comparison buffer of the rank below; a hole takes whatever comes. Equal importance: the lower queue
// number counts as larger [C], so that the settled order does not depend on history. The active queue is in rank 0 with
// infinite importance.
//
//   insert --> [comparison 0] [selected 0]      rank 0
//                    |  smaller
//              [comparison 1] [selected 1]      rank 1      shift_up: both buffers of every rank move up by one
//
// The model is exactly that machine, but it makes comparisons late and many at a time. Items in comparison buffers move
// down together, one rank per cycle, so no item catches up with another, and a younger item meets only the results of
// older ones. Therefore the items can be processed one after the other, oldest first: each goes down all its ranks at
// once, with its key in a register. Comparisons are made when their result is needed: for rank 0 at once, for a rank
// before its queue is wiped, and for all ranks from time to time. Ranks keep their positions in memory: shift_up moves
// only the origin [H305].
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

  // Whether the top's comparison buffer is free. It takes one insert per cycle, and none in a cycle in which shift_up
  // has filled it.
  bool can_insert() const { return !entering_; }
  // Puts a queue's new importance (1 .. kInfinite - 1) into the top's comparison buffer and removes its old item.
  void insert(std::uint32_t queue, std::uint32_t importance);

  // The queue in the top's selected buffer, or kNoQueue: a hole's lower half is no queue's number.
  std::uint32_t top() const { return queue_of(selected_[origin_]); }
  // Makes the top's queue active: its importance becomes infinite.
  void activate_top() {
    assert(top() != kNoQueue);
    selected_[origin_] = key(top(), kInfinite);
  }

  // Moves all ranks up by one and drops the item in the top's selected buffer. The top's comparison buffer must be
  // empty.
  void shift_up();

  // Whether some buffer holds the queue's item.
  bool has(std::uint32_t queue) const { return inserted_[queue] != kHole; }
  // Items in both kinds of buffers, including the active queue's.
  std::uint32_t size() const { return size_; }

  struct Item {
    std::uint32_t queue = kNoQueue;
    std::uint32_t importance = 0;
    friend bool operator==(const Item&, const Item&) = default;
  };
  // Contents of a rank's buffers, and whether any comparison buffer holds an item. Slow; for tests.
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
  // Upper half: importance; lower half: complement of the queue number. Keys compare as items do.
  using Key = std::uint64_t;
  static constexpr Key kHole = 0;
  // chosen: many enough cycles to amortise the set-up of an item, few enough to keep the list of items short.
  static constexpr std::uint32_t kMaxBehind = 10;

  // An item in a comparison buffer, or the item that it has pushed down.
  struct Moving {
    Key key = kHole;         // kHole once it has settled or was removed
    std::uint32_t at = 0;    // position of the first comparison not yet made
    std::uint32_t slot = 0;  // position minus steps: its current position is slot + steps_

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
    std::size_t at = item.at;  // of an address's width, which saves a conversion per comparison
    item.at = to;
    if (carried == kHole) return;
    while (at != to && carried < selected[at]) ++at;  // passes larger keys; the loop below pushes smaller ones down
    for (; at != to; ++at) {
      const Key here = selected[at];
      if (carried < here) continue;
      selected[at] = carried;
      carried = here;
      if (here == kHole) break;
    }
    item.key = carried;
  }
  // Makes all due comparisons above a position.
  void catch_up_to(std::uint32_t position);
  // Makes all due comparisons and drops settled items.
  void catch_up();
  InsertionSorter caught_up() const {
    InsertionSorter copy = *this;
    copy.catch_up();
    return copy;
  }
  // Replaces an item by a hole.
  void wipe(Key key);
  // Moves everything back to position 0.
  void begin_anew();

  std::uint32_t ranks_;
  std::uint32_t origin_ = 0;  // position of rank 0; up to ranks_
  std::uint32_t steps_ = 0;   // cycles with items in motion
  std::uint32_t behind_ = 0;  // cycles since all comparisons were made
  std::uint32_t size_ = 0;
  bool entering_ = false;      // rank 0's comparison buffer holds the last of moving_
  std::vector<Key> selected_;  // by position
  std::vector<Key>
      inserted_;  // by queue: its item, or kHole; without its position, which changes often and is rarely needed
  std::vector<Moving> moving_;  // oldest first, and so from the lowest rank upwards
};

// An ideal sorter that always has the most important queue: an upper bound [C]. It is a winner tree over the
// importances. Of equal ones the lower queue number wins.
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

  // The largest importance; 0 if all queues are empty.
  std::uint32_t importance() const { return importance_[1]; }
  // The most important queue. Some importance must be above 0.
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

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
// Exactly the machine above, but a cycle costs only as much as there are items in comparison buffers. Those move down
// together, one rank a cycle, so each is kept at a place of its own that does not change (position minus cycles), and
// shift_up moves only the origin.
#pragma once

#include <cassert>
#include <cstdint>
#include <vector>

namespace gicube::emu {

class InsertionSorter {
 public:
  static constexpr std::uint32_t kNoQueue = ~std::uint32_t{0};
  static constexpr std::uint32_t kInfinite = ~std::uint32_t{0};

  explicit InsertionSorter(std::uint32_t queues);

  // One cycle: every rank compares.
  void step() {
    if (!moving_.empty()) move_down();
  }

  // Whether the top's comparison buffer is free: one insert a cycle, and none where shift_up has filled it.
  bool can_insert() const { return comparison_[slot_of(origin_)] == kHole; }
  // Puts a queue's new importance (1 .. kInfinite - 1) into the top's comparison buffer and wipes it where it was.
  void insert(std::uint32_t queue, std::uint32_t importance);

  // The queue in the top's selected buffer, or kNoQueue.
  std::uint32_t top() const { return selected_[origin_] == kHole ? kNoQueue : queue_of(selected_[origin_]); }
  // The top's queue becomes active: its importance is infinite from now on.
  void activate_top() {
    assert(selected_[origin_] != kHole);
    selected_[origin_] = key(queue_of(selected_[origin_]), kInfinite);
  }

  // All ranks move up by one; what is in the top's selected buffer leaves. Its comparison buffer must be empty.
  void shift_up();

  // Items in comparison buffers.
  bool moving() const { return !moving_.empty(); }
  // Items in both kinds of buffers, the active queue among them.
  std::uint32_t size() const { return size_; }

  struct Item {
    std::uint32_t queue = kNoQueue;
    std::uint32_t importance = 0;
    friend bool operator==(const Item&, const Item&) = default;
  };
  // What a rank's buffers hold, for tests and reports.
  Item selected(std::uint32_t rank) const { return item(selected_[(origin_ + rank) & mask_]); }
  Item comparison(std::uint32_t rank) const { return item(comparison_[slot_of((origin_ + rank) & mask_)]); }

 private:
  // Importance above, complement of the queue number below: keys compare as items do.
  using Key = std::uint64_t;
  static constexpr Key kHole = 0;
  static constexpr std::uint32_t kNowhere = ~std::uint32_t{0};
  static constexpr std::uint32_t kMoving = std::uint32_t{1} << 31;  // place_: a slot of comparison_, not of selected_

  static Key key(std::uint32_t queue, std::uint32_t importance) { return Key{importance} << 32 | ~queue; }
  static std::uint32_t queue_of(Key key) { return ~static_cast<std::uint32_t>(key); }
  static Item item(Key key) {
    return key == kHole ? Item{} : Item{queue_of(key), static_cast<std::uint32_t>(key >> 32)};
  }
  std::uint32_t slot_of(std::uint32_t position) const { return (position - steps_) & mask_; }

  void move_down();

  std::uint32_t mask_;        // positions - 1; a power of two of them
  std::uint32_t origin_ = 0;  // position of rank 0
  std::uint32_t steps_ = 0;   // cycles with items in motion
  std::uint32_t size_ = 0;
  std::vector<Key> selected_;          // by position
  std::vector<Key> comparison_;        // by slot = position - steps
  std::vector<std::uint32_t> place_;   // by queue: where its item is
  std::vector<std::uint32_t> moving_;  // slots in use, lowest rank first; a wiped one is a hole until the next step
};

}  // namespace gicube::emu

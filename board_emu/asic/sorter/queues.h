// The ray queues of one processor: first in first out each, with slots and importance [P §3.2].
//
// A queue of capacity C has C slots. A ray takes one when it is written and gives it up when it has left the queue for
// good: while it is in the pipeline and may come back its slot is kept. So a ray that comes back to its queue always
// finds room. A slot that is given up while rays of the queue are with the DSP is kept for the first of them.
//
// The eDRAMs are one pool of records here, which grows with the rays that are there and not with the capacity.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <vector>

#include "asic/sorter/policies.h"
#include "words/words.h"

namespace gicube::emu {

class Queues {
 public:
  static constexpr std::uint32_t kUnlimited = ~std::uint32_t{0};

  // `capacity` in rays; kUnlimited for queues that never overflow.
  Queues(std::uint32_t queues, std::uint32_t capacity, v1::QueuePolicy policy)
      : capacity_(capacity), importance_of_(emu::importance_of(policy)), states_(queues) {}

  bool has_slot(std::uint32_t queue) const { return states_[queue].slots < capacity_; }
  bool has_slots(std::uint32_t queue, std::uint32_t count) const { return capacity_ - states_[queue].slots >= count; }
  bool has_overflowed(std::uint32_t queue) const { return states_[queue].overflowed > 0; }
  // Writes a ray under way to the queue's tail. It takes a slot unless it kept its own. Returns the rays in the queue.
  std::uint32_t write(std::uint32_t queue, const RayToken& token);
  // Takes the ray at the head, which must be there; its slot stays taken, its flag keeps_slot is down.
  RayToken read(std::uint32_t queue);
  // A ray has left for good. True if its slot goes to a ray that has overflowed, and stays taken for it.
  bool release_slot(std::uint32_t queue) {
    State& state = states_[queue];
    assert(state.slots > state.waiting);
    const bool hands_on = state.overflowed > 0;
    (hands_on ? state.overflowed : state.slots) -= 1;
    return hands_on;
  }
  void overflow(std::uint32_t queue) { ++states_[queue].overflowed; }

  // As the policy says; 0 = empty.
  std::uint32_t importance(std::uint32_t queue) const {
    const State& state = states_[queue];
    return state.waiting == 0 ? 0 : importance_of_(state);
  }
  std::uint32_t waiting(std::uint32_t queue) const { return states_[queue].waiting; }
  std::uint64_t waiting() const { return waiting_; }
  std::uint32_t slots_taken(std::uint32_t queue) const { return states_[queue].slots; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(states_.size()); }
  // No ray is here, and no slot is kept for one.
  bool all_free() const {
    const auto is_free = [](const State& state) { return state.slots == 0 && state.overflowed == 0; };
    return waiting_ == 0 && std::all_of(states_.begin(), states_.end(), is_free);
  }
  // The rays of each queue in their order; where they are kept is not in the file.
  void state(Archive& archive);

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct State : QueueFacts {
    std::uint32_t head = kNone;  // record
    std::uint32_t tail = kNone;
    std::uint32_t slots = 0;       // taken: waiting, issued and not released, or kept for a ray that has overflowed
    std::uint32_t overflowed = 0;  // rays that no slot is kept for yet
  };
  struct Record {
    RayToken token;
    std::uint32_t next = kNone;
  };
  static std::uint32_t weight(const RayToken& token) { return std::max<std::uint32_t>(1, token.contribution); }

  // A new record's number. Out of line: it is rare.
  [[gnu::noinline]] std::uint32_t grow() {
    records_.emplace_back();
    return static_cast<std::uint32_t>(records_.size() - 1);
  }

  std::uint32_t capacity_;
  ImportanceOf importance_of_;
  std::uint32_t free_ = kNone;  // list of unused records
  std::uint64_t waiting_ = 0;
  std::uint32_t openings_ = 0;  // queues that got a first ray since all were empty
  std::vector<State> states_;
  std::vector<Record> records_;
};

inline std::uint32_t Queues::write(std::uint32_t queue, const RayToken& token) {
  State& state = states_[queue];
  assert(token.state == TokenStatus::kUnderWay);
  if (!token.keeps_slot) {
    assert(has_slot(queue));
    ++state.slots;
  }
  assert(state.slots > state.waiting);
  const std::uint32_t at = free_ == kNone ? grow() : free_;
  Record* const records = records_.data();
  Record& record = records[at];
  free_ = record.next;
  record.token = token;
  record.token.keeps_slot = false;
  if (state.waiting == 0) {
    state.head = at;
    state.opened = waiting_ == 0 ? openings_ = 0 : ++openings_;
  } else {
    records[state.tail].next = at;
  }
  state.tail = at;
  state.contribution += weight(token);
  ++waiting_;
  return ++state.waiting;
}

inline RayToken Queues::read(std::uint32_t queue) {
  State& state = states_[queue];
  assert(state.waiting > 0);
  const std::uint32_t at = state.head;
  Record* const records = records_.data();
  Record& record = records[at];
  state.head = record.next;
  record.next = free_;
  free_ = at;
  --state.waiting;
  state.contribution -= weight(record.token);
  --waiting_;
  // The next ray of this queue is most likely read in the next cycle, and lies anywhere.
  if (state.waiting > 0) __builtin_prefetch(&records[state.head]);
  return record.token;
}

}  // namespace gicube::emu

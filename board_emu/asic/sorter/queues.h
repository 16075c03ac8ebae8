// The ray queues of one processor: first in first out each, with slots and importance [P §3.2] [H303, H306].
//
// A queue of capacity C has C slots. A ray takes a slot when it is written and releases it when it has left the queue
// for good. While it is in the pipeline and may return, its slot stays reserved, so a returning ray always finds room.
// If a slot is released while overflowed rays of the queue are with the DSP, it is reserved for the first of them.
//
// The model keeps all rays in one pool of records, which grows with the number of rays and not with the capacity.
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
  // Appends a ray to the queue. It takes a slot unless one is reserved for it. Returns the number of rays in the queue.
  std::uint32_t write(std::uint32_t queue, const RayToken& token);
  // Removes the ray at the head; the queue must not be empty. The slot stays taken; the ray's flag has_reserved_slot is
  // cleared.
  RayToken read(std::uint32_t queue);
  // Releases the slot of a ray that has left for good. True if the slot is reserved for an overflowed ray.
  bool release_slot(std::uint32_t queue) {
    State& state = states_[queue];
    assert(state.slots > state.waiting);
    const bool hands_on = state.overflowed > 0;
    (hands_on ? state.overflowed : state.slots) -= 1;
    return hands_on;
  }
  void overflow(std::uint32_t queue) { ++states_[queue].overflowed; }

  // By the policy; 0 for an empty queue.
  std::uint32_t importance(std::uint32_t queue) const {
    const State& state = states_[queue];
    return state.waiting == 0 ? 0 : importance_of_(state);
  }
  std::uint32_t waiting(std::uint32_t queue) const { return states_[queue].waiting; }
  std::uint64_t waiting() const { return waiting_; }
  std::uint32_t slots_taken(std::uint32_t queue) const { return states_[queue].slots; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(states_.size()); }
  // True if no ray waits and no slot is reserved.
  bool all_free() const {
    const auto is_free = [](const State& state) { return state.slots == 0 && state.overflowed == 0; };
    return waiting_ == 0 && std::all_of(states_.begin(), states_.end(), is_free);
  }
  // Saves the rays of each queue in their order, without their positions in the pool.
  void state(Archive& archive);

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct State : QueueFacts {
    std::uint32_t head = kNone;  // record
    std::uint32_t tail = kNone;
    std::uint32_t slots = 0;       // taken by waiting rays, by issued rays, or reserved for overflowed rays
    std::uint32_t overflowed = 0;  // overflowed rays without a reserved slot
  };
  struct Record {
    RayToken token;
    std::uint32_t next = kNone;
  };
  static std::uint32_t weight(const RayToken& token) { return std::max<std::uint32_t>(1, token.contribution); }

  // Returns the number of a new record. Out of line, because it is rare.
  [[gnu::noinline]] std::uint32_t grow() {
    records_.emplace_back();
    return static_cast<std::uint32_t>(records_.size() - 1);
  }

  std::uint32_t capacity_;
  ImportanceOf importance_of_;
  std::uint32_t free_ = kNone;  // list of unused records
  std::uint64_t waiting_ = 0;
  std::uint32_t openings_ = 0;  // queues that were opened since all were empty
  std::vector<State> states_;
  std::vector<Record> records_;
};

inline std::uint32_t Queues::write(std::uint32_t queue, const RayToken& token) {
  State& state = states_[queue];
  assert(token.state == TokenStatus::kUnderWay);
  if (!token.has_reserved_slot) {
    assert(has_slot(queue));
    ++state.slots;
  }
  assert(state.slots > state.waiting);
  const std::uint32_t at = free_ == kNone ? grow() : free_;
  Record* const records = records_.data();
  Record& record = records[at];
  free_ = record.next;
  record.token = token;
  record.token.has_reserved_slot = false;
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
  // The queue's next ray is probably read in the next cycle, and it may be anywhere in the pool.
  if (state.waiting > 0) __builtin_prefetch(&records[state.head]);
  return record.token;
}

}  // namespace gicube::emu

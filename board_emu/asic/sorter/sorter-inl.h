// Hot functions of a sorter, inlined into Sorter::work() and into the inner loop of the processor.
#pragma once

#include <algorithm>
#include <bit>
#include <cassert>

#include "asic/fifo_places.h"
#include "asic/sorter/sorter.h"

namespace gicube::emu {

inline void Sorter::list_dirty(std::uint32_t queue) {
  dirty_[queue] = {dirty_tail_, kNone};
  (dirty_tail_ == kNone ? dirty_head_ : dirty_[dirty_tail_].next) = queue;
  dirty_tail_ = queue;
}

inline void Sorter::unlist_dirty(std::uint32_t queue) {
  const Dirty entry = dirty_[queue];
  (entry.previous == kNone ? dirty_head_ : dirty_[entry.previous].next) = entry.next;
  (entry.next == kNone ? dirty_tail_ : dirty_[entry.next].previous) = entry.previous;
  dirty_[queue].next = kUnlisted;
}

inline void Sorter::modified(std::uint32_t queue) {
  if (queue == active_) return;  // its importance is infinite until it is empty
  if (!ranks_) {
    maximum_->set(queue, queues_.importance(queue));
  } else if (dirty_[queue].next == kUnlisted) {
    list_dirty(queue);
  }
}

inline void Sorter::give_up_active() {
  const auto bits = static_cast<std::size_t>(std::bit_width(issued_since_active_)) - 1;  // it had at least one ray
  const std::size_t bucket = std::min(bits, counters_.activation_rays.size() - 1);
  ++counters_.activation_rays[bucket];
  counters_.activation_issued[bucket] += issued_since_active_;
  active_ = kNone;
}

inline void Sorter::choose_active() {
  if (!ranks_) {
    active_ = maximum_->queue();
  } else {
    if (ranks_->top() == kNone) return;
    active_ = ranks_->top();
    ranks_->activate_top();
    if (dirty_[active_].next != kUnlisted) unlist_dirty(active_);
  }
  assert(queues_.waiting(active_) > 0);  // only the active queue loses rays
  latest_active_ = active_;
  ++counters_.activations;
  issued_since_active_ = 0;
}

inline void Sorter::write(std::uint32_t queue, const RayToken& token) {
  const std::uint32_t waiting = queues_.write(queue, token);
  ++counters_.written;
  counters_.peak_waiting = std::max<std::uint64_t>(counters_.peak_waiting, waiting);
  modified(queue);
}

inline bool Sorter::update_ranks() {
  bool moved = false;
  if (active_ != kNone) {
    if (queues_.waiting(active_) == 0) {
      give_up_active();
      ranks_->shift_up();
      moved = true;
    }
  } else if (ranks_->top() == kNone && ranks_->size() > 0 && ranks_->can_insert()) {
    ranks_->shift_up();  // a hole has reached the top rank
    moved = true;
  }
  if (dirty_head_ != kNone && ranks_->can_insert()) {
    const std::uint32_t queue = dirty_head_;
    unlist_dirty(queue);
    ranks_->insert(queue, queues_.importance(queue));
    ++counters_.inserts;
    moved = true;
  }
  return moved;
}

// Equivalent to work(), without the cases that its conditions exclude.
[[gnu::always_inline]] inline bool Sorter::tick_active_queue(const RayToken* returned, const std::uint32_t* released,
                                                             RayToken* issue, std::size_t& issued) {
  bool moved = returned != nullptr || released != nullptr;
  if (!moved && queues_.waiting() == 0) return false;
  ranks_->step();
  if (released != nullptr) queues_.release_slot(*released);
  if (active_ == kNone && queues_.waiting() > 0) choose_active();
  if (active_ != kNone && issued < kFifoPlaces) {
    issue[issued++] = queues_.read(active_);
    ++counters_.issued;
    ++issued_since_active_;
    moved = true;
  }
  if (returned != nullptr) write(returned->queue, *returned);
  return update_ranks() || moved;
}

}  // namespace gicube::emu

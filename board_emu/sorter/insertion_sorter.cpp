#include "sorter/insertion_sorter.h"

#include <algorithm>
#include <bit>

namespace gicube::emu {

InsertionSorter::InsertionSorter(std::uint32_t queues)
    : mask_(std::bit_ceil(std::max(queues, 2u)) - 1),
      selected_(mask_ + 1, kHole),
      comparison_(mask_ + 1, kHole),
      place_(queues, kNowhere) {}

void InsertionSorter::insert(std::uint32_t queue, std::uint32_t importance) {
  assert(queue < place_.size() && importance > 0 && importance < kInfinite && can_insert());
  const std::uint32_t place = place_[queue];
  if (place == kNowhere) {
    ++size_;
  } else {
    ((place & kMoving) != 0 ? comparison_[place & ~kMoving] : selected_[place]) = kHole;
  }
  const std::uint32_t slot = slot_of(origin_);
  comparison_[slot] = key(queue, importance);
  place_[queue] = slot | kMoving;
  // A slot that was wiped and is now at the top again (shift_up) is still listed, and then it is the youngest.
  if (moving_.empty() || moving_.back() != slot) moving_.push_back(slot);
}

void InsertionSorter::shift_up() {
  assert(can_insert());
  if (selected_[origin_] != kHole) {
    place_[queue_of(selected_[origin_])] = kNowhere;
    selected_[origin_] = kHole;
    --size_;
  }
  origin_ = (origin_ + 1) & mask_;
}

void InsertionSorter::move_down() {
  std::size_t kept = 0;
  for (const std::uint32_t slot : moving_) {
    Key& moving = comparison_[slot];
    if (moving == kHole) continue;  // wiped
    const std::uint32_t position = (slot + steps_) & mask_;
    Key& selected = selected_[position];
    if (moving > selected) {
      std::swap(moving, selected);
      place_[queue_of(selected)] = position;
      if (moving == kHole) continue;
      place_[queue_of(moving)] = slot | kMoving;
    }
    moving_[kept++] = slot;
  }
  moving_.resize(kept);
  ++steps_;
}

}  // namespace gicube::emu

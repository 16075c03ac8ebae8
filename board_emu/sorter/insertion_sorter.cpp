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
  // Copies of what the stores below could change, as far as a compiler knows.
  const std::uint32_t steps = steps_, mask = mask_;
  Key* const comparison = comparison_.data();
  Key* const selected = selected_.data();
  std::uint32_t* const place = place_.data();
  std::uint32_t* kept = moving_.data();
  for (const std::uint32_t *at = kept, *const end = kept + moving_.size(); at != end; ++at) {
    const std::uint32_t slot = *at;
    const std::uint32_t position = (slot + steps) & mask;
    const Key from_above = comparison[slot], here = selected[position];
    if (from_above > here) {
      selected[position] = from_above;
      comparison[slot] = here;
      place[queue_of(from_above)] = position;
      if (here == kHole) continue;  // took it
      place[queue_of(here)] = slot | kMoving;
    } else if (from_above == kHole) {
      continue;  // wiped
    }
    *kept++ = slot;
  }
  moving_.resize(static_cast<std::size_t>(kept - moving_.data()));
  ++steps_;
}

}  // namespace gicube::emu

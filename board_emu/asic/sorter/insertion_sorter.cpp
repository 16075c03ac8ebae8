#include "asic/sorter/insertion_sorter.h"

#include <algorithm>
#include <limits>

namespace gicube::emu {

InsertionSorter::InsertionSorter(std::uint32_t queues)
    : ranks_(queues), selected_(2 * std::size_t{queues} + 1, kHole), inserted_(queues, kHole) {}

void InsertionSorter::insert(std::uint32_t queue, std::uint32_t importance) {
  assert(queue < inserted_.size() && importance > 0 && importance < kInfinite && can_insert());
  if (inserted_[queue] == kHole) {
    ++size_;
  } else {
    wipe(inserted_[queue]);
  }
  inserted_[queue] = key(queue, importance);
  moving_.push_back({inserted_[queue], origin_, origin_ - steps_});
  entering_ = true;
}

void InsertionSorter::wipe(Key key) {
  for (;;) {
    // It is usually one of the youngest, because rays of neighbouring pixels reach a queue soon after one another.
    const auto is_it = [key](const Moving& item) { return item.key == key; };
    if (const auto item = std::find_if(moving_.rbegin(), moving_.rend(), is_it); item != moving_.rend()) {
      if (item->at == item->slot + steps_) {
        item->key = kHole;
        return;
      }
      catch_up_to(item->slot + steps_);
    } else {
      const auto found = std::find(selected_.begin() + origin_, selected_.end(), key);
      assert(found != selected_.end());
      catch_up_to(static_cast<std::uint32_t>(found - selected_.begin()) + 1);
      if (*found == key) {
        *found = kHole;
        return;
      }
    }
    // Another item has pushed it down, or it has settled.
  }
}

void InsertionSorter::shift_up() {
  assert(can_insert());
  if (top() != kNoQueue) {
    inserted_[top()] = kHole;
    selected_[origin_] = kHole;
    --size_;
  }
  if (++origin_ > ranks_) begin_anew();
  // The new top rank must be up to date: its selected buffer, and whether its comparison buffer is full.
  catch_up_to(origin_ + 1);
  entering_ = !moving_.empty() && moving_.back().key != kHole && moving_.back().at == origin_;
}

void InsertionSorter::begin_anew() {
  catch_up();
  std::fill(std::move(selected_.begin() + origin_, selected_.end(), selected_.begin()), selected_.end(), kHole);
  for (Moving& item : moving_) {
    item.at -= origin_;
    item.slot -= origin_;
  }
  origin_ = 0;
}

void InsertionSorter::catch_up_to(std::uint32_t position) {
  auto item = moving_.end();
  while (item != moving_.begin() && (item - 1)->at < position) --item;  // none overtakes an older one
  for (; item != moving_.end(); ++item) move_down(*item, std::min(position, item->slot + steps_));
}

// Makes all due comparisons first, so that the position describes an item in motion, and restarts the count of steps.
void InsertionSorter::state(Archive& archive) {
  if (!archive.loads()) catch_up();
  archive.at_most("origin", origin_, ranks_);
  archive.at_most("size", size_, ranks_);
  archive("entering", entering_);
  archive("selected", selected_);
  archive("inserted", inserted_);
  archive.list("moving", moving_, ranks_);
  if (!archive.loads()) return;
  std::vector<Key> found;
  for (std::size_t at = 0; at < selected_.size(); ++at) {
    if (selected_[at] == kHole) continue;
    archive.expect(at >= origin_ && at < origin_ + ranks_, "selected", "items only at the positions of ranks", at);
    const std::uint32_t queue = queue_of(selected_[at]);
    const bool is_active = at == origin_ && queue < inserted_.size() && selected_[at] == key(queue, kInfinite);
    found.push_back(is_active ? inserted_[queue] : selected_[at]);
  }
  std::uint32_t before = origin_ + ranks_ + 1;
  for (Moving& item : moving_) {
    archive.expect(item.at >= origin_ && item.at < before, "moving", "positions of ranks, the lowest rank first",
                   item.at);
    item.slot = item.at - steps_;
    before = item.at;
    found.push_back(item.key);
  }
  std::vector<Key> known;
  for (std::uint32_t queue = 0; queue < inserted_.size(); ++queue) {
    if (inserted_[queue] == kHole) continue;
    archive.expect(queue_of(inserted_[queue]) == queue, "inserted", "the key of the same queue", inserted_[queue]);
    known.push_back(inserted_[queue]);
  }
  std::ranges::sort(found);
  std::ranges::sort(known);
  archive.expect(found == known && found.size() == size_, "size", "one item of each inserted queue", found.size());
  archive.expect(!entering_ || (!moving_.empty() && moving_.back().at == origin_), "entering", "0", 1);
}

void InsertionSorter::catch_up() {
  behind_ = 0;
  catch_up_to(std::numeric_limits<std::uint32_t>::max());
  std::erase_if(moving_, [](const Moving& item) { return item.key == kHole; });
}

}  // namespace gicube::emu

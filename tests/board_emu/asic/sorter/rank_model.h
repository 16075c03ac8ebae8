// The insertion sorter of Figure 7 as it is drawn: every rank has two buffers and compares them in every cycle.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "asic/sorter/insertion_sorter.h"

namespace gicube::emu {

class RankModel {
 public:
  using Item = InsertionSorter::Item;

  explicit RankModel(std::size_t ranks) : selected_(ranks), comparison_(ranks + 1) {}

  void step() {
    std::vector<Item> below(comparison_.size());
    for (std::size_t rank = 0; rank < selected_.size(); ++rank) {
      if (is_larger(comparison_[rank], selected_[rank])) std::swap(comparison_[rank], selected_[rank]);
      below[rank + 1] = comparison_[rank];
    }
    lost_ |= below.back() != Item{};
    comparison_ = below;
  }

  bool can_insert() const { return comparison_[0] == Item{}; }
  void insert(std::uint32_t queue, std::uint32_t importance) {
    for (auto* buffers : {&selected_, &comparison_}) {
      for (Item& item : *buffers) {
        if (item.queue == queue) item = {};
      }
    }
    comparison_[0] = {queue, importance};
  }
  void activate_top() { selected_[0].importance = InsertionSorter::kInfinite; }
  void shift_up() {
    selected_.erase(selected_.begin());
    selected_.emplace_back();
    comparison_.erase(comparison_.begin());
    comparison_.emplace_back();
  }

  Item selected(std::uint32_t rank) const { return selected_[rank]; }
  Item comparison(std::uint32_t rank) const { return comparison_[rank]; }
  bool lost() const { return lost_; }  // an item fell out at the bottom

 private:
  static bool is_larger(const Item& a, const Item& b) {
    return a.importance != b.importance ? a.importance > b.importance : a.queue < b.queue;
  }

  std::vector<Item> selected_;
  std::vector<Item> comparison_;
  bool lost_ = false;
};

}  // namespace gicube::emu

// Rays on their way between parts, and the queue that holds them.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "gicube/archive.h"
#include "words/clock.h"

namespace gicube::emu {

// First in, first out; grows as needed.
template <typename Item>
class LongQueue {
 public:
  LongQueue() = default;
  explicit LongQueue(std::size_t first) : head_(first), tail_(first) {}

  bool empty() const { return head_ == tail_; }
  std::size_t size() const { return tail_ - head_; }
  // Items have the numbers begin() .. end() - 1 for as long as they are here.
  std::size_t begin() const { return head_; }
  std::size_t end() const { return tail_; }
  Item& operator[](std::size_t number) { return ring_[number & mask_]; }
  const Item& operator[](std::size_t number) const { return ring_[number & mask_]; }
  const Item& front() const { return ring_[head_ & mask_]; }
  void drop() { ++head_; }
  void clear() { head_ = tail_; }
  Item pop() { return ring_[head_++ & mask_]; }
  void push(const Item& item) { add() = item; }
  // At the end, as an earlier item has left it.
  Item& add() {
    if (size() > mask_) [[unlikely]]
      grow();
    return ring_[tail_++ & mask_];
  }
  // For a caller that takes the first and puts one at the end, again and again: the item of a number is at number & mask().
  // rotated() says how often it did so.
  Item* places() { return ring_.data(); }
  std::size_t mask() const { return mask_; }
  void rotated(std::size_t times) {
    head_ += times;
    tail_ += times;
  }
  // Before the item of that number, which is now the next one, as are those behind it.
  void insert(std::size_t number, const Item& item) {
    assert(number >= head_);
    push(item);
    for (std::size_t i = tail_ - 1; i > number; --i) ring_[i & mask_] = ring_[(i - 1) & mask_];
    ring_[number & mask_] = item;
  }
  // Its items keep their numbers.
  void state(Archive::Record& record) {
    std::vector<Item> items;
    for (std::size_t i = head_; i != tail_; ++i) items.push_back((*this)[i]);
    record(head_);
    record.list(items, std::numeric_limits<std::uint32_t>::max());
    *this = LongQueue(head_);
    for (const Item& item : items) push(item);
  }
  // Of one that is empty: the number of the next item.
  void empty_state(Archive::Record& record) {
    record(head_);
    tail_ = head_;
  }

 private:
  void grow() {
    std::vector<Item> larger(2 * ring_.size());
    const std::size_t mask = larger.size() - 1;
    for (std::size_t i = head_; i < tail_; ++i) larger[i & mask] = ring_[i & mask_];
    mask_ = mask;
    ring_.swap(larger);
  }

  std::vector<Item> ring_ = std::vector<Item>(1);
  std::size_t mask_ = 0;
  std::size_t head_ = 0, tail_ = 0;
};

// A ray on its way to a queue, or to the DSP; or a queue's word to the DSP that it keeps a slot for its first overflowed ray.
struct Arrival {
  enum class Kind : std::uint8_t { kRay, kToItsSlot, kOverflowed, kSlot };

  Cycle ready = 0;
  std::uint32_t ray = 0;  // handle
  std::uint32_t queue = 0;
  Kind kind = Kind::kRay;
  std::uint8_t processor = 0;  // to the DSP: that it comes from

  bool overflow() const { return kind >= Kind::kOverflowed; }  // on that leaf of the merge tree
};

}  // namespace gicube::emu

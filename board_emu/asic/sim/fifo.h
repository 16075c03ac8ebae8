// A registered FIFO between two parts: a push or pop takes effect at the clock edge that ends its cycle.
//
// The order in which parts tick within a cycle therefore never matters. It takes one push and one pop per cycle. A
// capacity of 2 keeps the full rate; 1 halves it, because an entry that a pop frees becomes visible one cycle later.
#pragma once

#include <bit>
#include <cassert>
#include <cstddef>
#include <vector>

#include "gicube/archive.h"
#include "words/clock.h"

namespace gicube::emu {

template <typename T>
class Fifo {
 public:
  explicit Fifo(std::size_t capacity)
      : items_(std::bit_ceil(capacity)), mask_(items_.size() - 1), capacity_(capacity) {}

  // Both halves are always evaluated, because a branch between them would be hard to predict.
  bool can_push(Cycle now) const { return (last_push_ != now) & (size_ + (last_pop_ == now ? 1 : 0) < capacity_); }
  // Free entries, as seen by the pushing side at `now`.
  std::size_t room(Cycle now) const { return capacity_ - size_ - (last_pop_ == now ? 1 : 0); }
  void push(Cycle now, const T& item) {
    assert(can_push(now));
    items_[(head_ + size_) & mask_] = item;
    ++size_;
    last_push_ = now;
  }

  bool can_pop(Cycle now) const { return (last_pop_ != now) & (size_ > (last_push_ == now ? 1u : 0u)); }
  const T& front() const { return items_[head_ & mask_]; }
  // The item pushed last. It may not be visible yet: use it for prefetching only.
  const T& back() const { return items_[(head_ + size_ - 1) & mask_]; }
  const T& operator[](std::size_t i) const { return items_[(head_ + i) & mask_]; }
  T pop(Cycle now) {
    assert(can_pop(now));
    const T item = items_[head_++ & mask_];
    --size_;
    last_pop_ = now;
    return item;
  }

  bool pushed(Cycle now) const { return last_push_ == now; }
  // True if it holds no item, including those that become visible at the next edge.
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  // For the popping side, before it pops: the FIFO was full when the cycle began.
  bool was_full(Cycle now) const { return size_ - (last_push_ == now ? 1 : 0) == capacity_; }
  struct Clock {
    Cycle push, pop;  // cycles of the last push and pop
  };
  Clock clock() const { return {last_push_, last_pop_}; }
  // Replaces the items, for a caller that has held them in registers during some earlier cycles.
  void put_back(const T* items, std::size_t count) {
    for (size_ = 0; size_ < count; ++size_) items_[(head_ + size_) & mask_] = items[size_];
  }
  void state(Archive::Record& record) {
    record.at_most(size_, capacity_);
    record.times(last_push_, last_pop_);
    for (std::size_t i = 0; i < size_; ++i) record(items_[(head_ + i) & mask_]);
  }

 private:
  std::vector<T> items_;  // its size is a power of two
  std::size_t mask_;
  std::size_t capacity_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
  Cycle last_push_ = kNoCycle;
  Cycle last_pop_ = kNoCycle;
};

}  // namespace gicube::emu

#include "lone_processors.h"

#include <algorithm>

namespace gicube::emu {

namespace {

constexpr int kSpins = 256;  // chosen: some microseconds, then another program may have the core

void pause(int& spins) {
  if (++spins < kSpins) {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
    return;
  }
  spins = 0;
  std::this_thread::yield();
}

}  // namespace

void LoneProcessors::begin(Cycle now, const std::vector<std::unique_ptr<Processor>>& processors,
                           const std::vector<std::unique_ptr<MemoryPort>>& memories, unsigned others) {
  end();
  count_ = processors.size();
  if (!parts_) parts_ = std::make_unique<Part[]>(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    parts_[i].processor = processors[i].get();
    parts_[i].memory = memories[i].get();
    parts_[i].is_left = false;
    parts_[i].alone_until = now;
    parts_[i].is_held = true;
    parts_[i].moved = 0;
  }
  skip(now);
  tell(now);
  for (unsigned i = 1; i <= others; ++i) {
    others_.emplace_back([this, first = i * count_ / (others + 1)](const std::stop_token& stop) { help(stop, first); });
  }
}

void LoneProcessors::end() { others_.clear(); }

void LoneProcessors::run(Part& part, Cycle to) {
  Cycle next = part.next.load(std::memory_order_relaxed);
  for (; next < to; ++next) {
    if (part.processor->tick_alone(next)) part.moved = next;
    if (part.processor->asks_memory()) part.memory->tick_ahead(next);
  }
  part.next.store(next, std::memory_order_relaxed);
}

void LoneProcessors::help(const std::stop_token& stop, std::size_t first) {
  int spins = 0;
  while (!stop.stop_requested()) {
    bool helped = false;
    for (std::size_t i = 0; i < count_; ++i) {
      Part& part = parts_[(first + i) % count_];
      const auto end = [&] {
        return std::min(now_.load(std::memory_order_acquire), part.until.load(std::memory_order_relaxed));
      };
      if (part.is_held.load(std::memory_order_relaxed)) continue;
      if (end() < part.next.load(std::memory_order_relaxed) + kWorth) continue;
      if (part.is_held.exchange(true, std::memory_order_acquire)) continue;
      run(part, end());
      part.is_held.store(false, std::memory_order_release);
      helped = true;
    }
    if (!helped) pause(spins);
  }
}

void LoneProcessors::leave(std::size_t i, Cycle next, Cycle until) {
  Part& part = parts_[i];
  part.next.store(next, std::memory_order_relaxed);
  part.alone_until = until;
  part.has_many_rays = part.processor->holds_many_rays();
  if (until <= next || others_.empty()) return;
  part.until.store(until, std::memory_order_relaxed);
  part.is_left = true;
  part.is_held.store(false, std::memory_order_release);
}

Cycle LoneProcessors::hold(Part& part, Cycle to) {
  int spins = 0;
  while (part.is_left && part.is_held.exchange(true, std::memory_order_acquire)) pause(spins);
  part.is_left = false;
  run(part, to);
  return part.moved;
}

Cycle LoneProcessors::take(std::size_t i, Cycle to) {
  parts_[i].alone_until = to;
  return hold(parts_[i], to);
}

Cycle LoneProcessors::take_all(Cycle to) {
  Cycle moved = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (parts_[i].alone_until >= to) moved = std::max(moved, hold(parts_[i], to));
  }
  return moved;
}

void LoneProcessors::leave_all(Cycle now) {
  for (std::size_t i = 0; i < count_; ++i) {
    if (goes_alone(i, now)) leave(i, now, parts_[i].alone_until);
  }
}

}  // namespace gicube::emu

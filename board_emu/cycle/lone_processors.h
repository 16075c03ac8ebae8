// Processors that go alone (Processor::alone_until()) are ticked later than their cycles, many at a time, by the machine's thread
// when it must know what they did, or before by others. What a processor needs then stays in the host's cache.
//
// Whoever ticks a processor holds it. The machine's thread holds those that don't go alone.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <thread>
#include <vector>

#include "memory_port.h"
#include "processor.h"

namespace gicube::emu {

class LoneProcessors {
 public:
  LoneProcessors() = default;
  LoneProcessors(const LoneProcessors&) = delete;
  LoneProcessors& operator=(const LoneProcessors&) = delete;
  ~LoneProcessors() { end(); }

  // All are at cycle `now`. Each has a memory of its own. Starts `others` threads.
  void begin(Cycle now, const std::vector<std::unique_ptr<Processor>>& processors,
             const std::vector<std::unique_ptr<MemoryPort>>& memories, unsigned others);
  // Stops the threads. The machine holds all.
  void end();

  // Those that go alone have done no cycle from `now` on yet, but may do all before.
  void tell(Cycle now) { now_.store(now, std::memory_order_release); }
  // Whether the machine need not tick it in this cycle, unless something comes.
  bool goes_alone(std::size_t i, Cycle now) const { return now < parts_[i].alone_until; }
  Cycle alone_until(std::size_t i) const { return parts_[i].alone_until; }
  // It ticks next in cycle `next`, and goes alone until then.
  void leave(std::size_t i, Cycle next, Cycle until);
  // It holds_rays() all the time.
  bool has_many_rays(std::size_t i) const { return parts_[i].has_many_rays; }
  // The machine holds it, and has ticked it in all cycles before `to`; it goes alone no longer. Returns the last in which something
  // moved.
  Cycle take(std::size_t i, Cycle to);
  // The same, but it still goes alone, and may be left.
  Cycle hold(std::size_t i, Cycle to) { return hold(parts_[i], to); }
  // The same of all; they still go alone, and may be left.
  Cycle take_all(Cycle to);
  void leave_all(Cycle now);
  // While one, or nobody, goes alone: it ticks next in cycle `now`.
  void skip(std::size_t i, Cycle now) { parts_[i].next.store(now, std::memory_order_relaxed); }
  void skip(Cycle now) {
    for (std::size_t i = 0; i < count_; ++i) skip(i, now);
  }

 private:
  static constexpr Cycle kWorth = 8;  // cycles; chosen: many for each change of hands

  struct alignas(64) Part {
    Processor* processor = nullptr;
    MemoryPort* memory = nullptr;
    // Of the machine's thread:
    bool is_left = false;
    bool has_many_rays = false;
    Cycle alone_until = 0;
    // Of who holds it; others read to see whether there is something to do.
    alignas(64) std::atomic<bool> is_held{true};
    std::atomic<Cycle> next{0}, until{0};
    Cycle moved = 0;
  };
  static void run(Part& part, Cycle to);
  static Cycle hold(Part& part, Cycle to);
  void help(const std::stop_token& stop, std::size_t first);

  std::unique_ptr<Part[]> parts_;
  std::size_t count_ = 0;
  alignas(64) std::atomic<Cycle> now_{0};
  std::vector<std::jthread> others_;
};

}  // namespace gicube::emu

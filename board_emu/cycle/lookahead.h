// Lookahead: processors that run ahead (Processor::lookahead_until()) are ticked later than their cycles, many at a time, when the
// machine must know what they did. What a processor needs then stays in the host's cache.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "memory_port.h"
#include "processor.h"

namespace gicube::emu {

class Lookahead {
 public:
  // All are at cycle `now`. Each has a memory of its own.
  void begin(Cycle now, const std::vector<std::unique_ptr<Processor>>& processors,
             const std::vector<std::unique_ptr<MemoryPort>>& memories);

  // Whether the machine need not tick it in this cycle, unless something comes.
  bool is_ahead(std::size_t i, Cycle now) const { return now < parts_[i].ahead_until; }
  Cycle ahead_until(std::size_t i) const { return parts_[i].ahead_until; }
  // It ticks next in cycle `next`, and goes alone until then.
  void start(std::size_t i, Cycle next, Cycle until) {
    Part& part = parts_[i];
    part.next = next;
    part.ahead_until = until;
    part.has_many_rays = part.processor->holds_many_rays();
  }
  // It holds_rays() all the time.
  bool has_many_rays(std::size_t i) const { return parts_[i].has_many_rays; }
  // It has ticked in all cycles before `to`. Returns the last in which something moved.
  Cycle catch_up(std::size_t i, Cycle to) {
    Part& part = parts_[i];
    if (part.next < to) {
      part.moved = std::max(part.moved, part.processor->run_ahead(part.next, to, *part.memory));
      cycles_ahead_ += to - part.next;
      part.next = to;
    }
    return part.moved;
  }
  // The same, and it goes alone no longer.
  Cycle stop(std::size_t i, Cycle to) {
    parts_[i].ahead_until = to;
    return catch_up(i, to);
  }
  // All that go alone.
  Cycle catch_up_all(Cycle to);
  // While one, or nobody, goes alone: it ticks next in cycle `now`.
  void skip(std::size_t i, Cycle now) { parts_[i].next = now; }
  void skip(Cycle now) {
    for (Part& part : parts_) part.next = now;
  }

  // Of all processors, in all runs.
  std::uint64_t cycles_ahead() const { return cycles_ahead_; }

 private:
  struct Part {
    Processor* processor = nullptr;
    MemoryPort* memory = nullptr;
    bool has_many_rays = false;
    Cycle ahead_until = 0;
    Cycle next = 0;
    Cycle moved = 0;
  };

  std::vector<Part> parts_;
  std::uint64_t cycles_ahead_ = 0;
};

}  // namespace gicube::emu

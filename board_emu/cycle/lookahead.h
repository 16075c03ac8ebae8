// Lookahead: processors that run ahead (Processor::lookahead_until()) are ticked later than their cycles, many at a
// time, when the machine must know what they did. What a processor needs then stays in the host's cache.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "memory_port.h"
#include "processor.h"

namespace gicube::emu {

class Lookahead {
 public:
  // All processors are at cycle `now`. Each must have its own memory.
  void begin(Cycle now, const std::vector<std::unique_ptr<Processor>>& processors,
             const std::vector<std::unique_ptr<MemoryPort>>& memories);

  // Whether processor `i` runs ahead: the machine need not tick it in cycle `now`, unless a ray arrives.
  bool is_ahead(std::size_t i, Cycle now) const { return now < parts_[i].ahead_until; }
  Cycle ahead_until(std::size_t i) const { return parts_[i].ahead_until; }
  // Processor `i` runs ahead until cycle `until`. `next`: the first cycle in which it has not ticked.
  void start(std::size_t i, Cycle next, Cycle until) {
    Part& part = parts_[i];
    part.started = part.next = next;
    part.ahead_until = until;
    part.has_many_rays = part.processor->holds_many_rays();
  }
  // Whether it holds rays in every cycle in which it runs ahead.
  bool has_many_rays(std::size_t i) const { return parts_[i].has_many_rays; }
  // Ticks it in all cycles before `to` in which it has not ticked. Returns the last cycle in which something moved.
  Cycle catch_up(std::size_t i, Cycle to) {
    Part& part = parts_[i];
    if (part.next < to) {
      part.moved = std::max(part.moved, part.processor->run_ahead(part.next, to, *part.memory));
      cycles_ahead_ += to - part.next;
      part.next = to;
    }
    return part.moved;
  }
  // After stop(): whether it has run ahead up to cycle `now`, and does so again, because it sends and receives nothing.
  bool goes_on(std::size_t i, Cycle now) {
    Part& part = parts_[i];
    if (part.started == now || part.processor->has_input()) return false;
    const Cycle until = part.processor->lookahead_until(now - 1);
    if (until == now) return false;
    start(i, now, until);
    return true;
  }
  // Ends its running ahead, and catches up.
  Cycle stop(std::size_t i, Cycle to) {
    parts_[i].ahead_until = to;
    return catch_up(i, to);
  }
  // Calls catch_up() for all processors that run ahead. Returns the last cycle in which something moved.
  Cycle catch_up_all(Cycle to);
  // The machine has accounted for the cycles before `now` itself, of processor `i` or of all processors.
  void skip(std::size_t i, Cycle now) { parts_[i].next = now; }
  void skip(Cycle now) {
    for (Part& part : parts_) part.next = now;
  }

  // Sum over all processors and runs.
  std::uint64_t cycles_ahead() const { return cycles_ahead_; }

 private:
  struct Part {
    Processor* processor = nullptr;
    MemoryPort* memory = nullptr;
    bool has_many_rays = false;
    Cycle ahead_until = 0;
    Cycle started = 0;  // the first cycle in which it ran ahead
    Cycle next = 0;
    Cycle moved = 0;
  };

  std::vector<Part> parts_;
  std::uint64_t cycles_ahead_ = 0;
};

}  // namespace gicube::emu

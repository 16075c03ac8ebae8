// A sorter with all its FIFOs, and a hand for each.
#pragma once

#include <deque>
#include <map>
#include <vector>

#include "asic/sorter/sorter.h"

namespace gicube::emu {

struct SorterRig {
  explicit SorterRig(const SorterSetup& setup, std::size_t outputs = 64)
      : issue(outputs), overflow(outputs), sorter(setup, {returned, bus, left, right, released}, {issue, overflow}) {}

  static RayToken ray(std::uint32_t id, std::uint32_t queue, std::uint16_t contribution = 4095) {
    return {.ray = id, .queue = queue, .contribution = contribution};
  }

  // One cycle.
  void tick() { sorter.tick(now++); }
  void tick(int cycles) {
    while (cycles-- > 0) tick();
  }
  // Rays that came out by the end of this cycle, in their order.
  static std::vector<std::uint32_t> drain(Fifo<RayToken>& fifo, Cycle& clock) {
    std::vector<std::uint32_t> rays;
    for (; !fifo.empty(); ++clock) {
      if (fifo.can_pop(clock)) rays.push_back(fifo.pop(clock).ray);
    }
    return rays;
  }
  std::vector<std::uint32_t> issued() { return drain(issue, now); }
  std::vector<std::uint32_t> overflowed() { return drain(overflow, now); }

  Cycle now = 0;
  Fifo<RayToken> returned{64}, bus{64}, left{64}, right{64};
  Fifo<std::uint32_t> released{64};
  Fifo<RayToken> issue, overflow;
  Sorter sorter;
};

}  // namespace gicube::emu

// The clock of the simulated host (docs/reference/protocol.md, simulated time). It moves when the host works and when
// it waits for the board, never with the wall clock.
#pragma once

#include <atomic>
#include <limits>

#include "gicube/time.h"

namespace gicube {

// now() may be read from any thread; the two others by one caller at a time.
class HostClock {
 public:
  Picoseconds now() const { return now_.load(std::memory_order_relaxed); }

  // The host works for `duration`. Stays at the end of time instead of starting again at 0.
  void work(Picoseconds duration) {
    const Picoseconds left = std::numeric_limits<Picoseconds>::max() - now();
    now_.store(now() + (duration < left ? duration : left), std::memory_order_relaxed);
  }

  // The host was blocked until `time`; what lies in its past does not move it.
  void wait_until(Picoseconds time) {
    if (time > now()) now_.store(time, std::memory_order_relaxed);
  }

 private:
  std::atomic<Picoseconds> now_{0};
};

}  // namespace gicube

// Exponential back-off for an event: after each event the pause doubles, up to a limit. It starts again when there was
// no event for as long as the limit. Not thread-safe.
#pragma once

#include <algorithm>
#include <chrono>

namespace gicube::emu {

class BackOff {
 public:
  using Clock = std::chrono::steady_clock;
  using Duration = std::chrono::milliseconds;

  BackOff(Duration first, Duration longest) : first_(first), longest_(longest) {}

  bool allows(Clock::time_point now) const { return now >= next_; }
  // Remaining pause; 0 if the event is allowed.
  Duration left(Clock::time_point now) const {
    return allows(now) ? Duration{0} : std::chrono::ceil<Duration>(next_ - now);
  }
  void happened(Clock::time_point now) {
    const bool begins = pause_ == Duration{0} || now >= next_ + longest_;
    pause_ = begins ? first_ : std::min(2 * pause_, longest_);
    next_ = now + pause_;
  }

 private:
  Duration first_, longest_, pause_{0};
  Clock::time_point next_{};
};

}  // namespace gicube::emu

// When the next of something may happen that is not to happen often: after each one twice as late as before, up to a limit. It begins
// anew once nothing has happened for as long as that limit. Not locked.
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
  // How long it is not allowed yet; 0: it is.
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

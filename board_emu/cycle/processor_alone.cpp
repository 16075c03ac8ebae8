// For how long nobody round a processor has to know what it does.
#include <algorithm>

#include "processor.h"

namespace gicube::emu {

// What enters the pipeline from now on comes out of it behind this time, so only what is in it counts, and what has just left it.
Cycle Processor::alone_until(Cycle now) const {
  const Cycle next = now + 1;
  const Cycle line = stages_.prefetch_stages() + stages_.compute_stages();
  // Never empty before then: else it would matter why no ray comes. Carriers end in it.
  const std::size_t rays = sorter_.waiting() + issue_.size() + stages_.size() + returned_.size();
  const std::size_t outside = has_input() | out_links.size() | done.size() | overflow.size();
  if (rays < (scatters_or_deposits_ ? 2 * line + kMany : 1) || outside != 0 || sorter_.has_kept_slots() ||
      splats_.has_carrier())
    return next;
  const auto others = static_cast<std::uint32_t>(stages_.size() + returned_.size());
  for (std::size_t i = 0; i < returned_.size(); ++i) {
    if (!returned_[i].keeps_slot && !sorter_.has_room(returned_[i].queue, others)) return next;
  }
  for (std::size_t i = 0; i < released_.size(); ++i) {
    if (sorter_.would_keep(released_[i])) return next;
  }
  std::size_t splats = 0;
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    const InFlight& ray = stages_[i];
    const bool carries = ray.splats && splats_.waiting(splats++).carriers > 0;
    if (ray.token.keeps_slot && !carries) continue;
    // When it can come out at the earliest.
    const Cycle out = i < stages_.computing() ? next + (ray.ready > compute_clock_ ? ray.ready - compute_clock_ : 0)
                                              : std::max(ray.ready, next) + stages_.compute_stages();
    const bool is_gone = ray.token.state == TokenStatus::kGone;
    const bool leaves = !is_gone && (ray.token.state != TokenStatus::kUnderWay || ray.token.processor != number_);
    if (leaves || carries) return out;
    if (!is_gone && !sorter_.has_room(ray.token.queue, others)) return out + 1;
    if (sorter_.would_keep(ray.from)) return out + 1;
  }
  return next + line;
}

}  // namespace gicube::emu

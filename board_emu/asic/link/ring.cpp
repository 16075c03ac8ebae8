#include "asic/link/ring.h"

#include <cassert>
#include <ostream>

namespace gicube::emu {

Ring::Ring(std::uint32_t bits, std::uint32_t rays, const std::vector<Port>& ports)
    : cycles_per_ray_((wire::kRayBits + bits - 1) / bits), ports_(ports), counters_(ports.size()) {
  assert(bits >= 1 && bits <= wire::kRayBits && rays >= kPlacesToEnter);
  const std::size_t count = ports.size();
  if (count == 1) return;  // no neighbours, no links
  for (auto& links : links_) links.assign(count, Link(rays));
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t right = (i + 1) % count, left = (i + count - 1) % count;
    Link& to_right = links_[kRight][i];
    to_right.end = static_cast<std::uint8_t>(right);
    to_right.arrival = ports[right].from_left;
    to_right.next = &links_[kRight][right];
    Link& to_left = links_[kLeft][i];
    to_left.end = static_cast<std::uint8_t>(left);
    to_left.arrival = ports[left].from_right;
    to_left.next = &links_[kLeft][left];
  }
}

bool Ring::work(Cycle now) {
  const auto count = static_cast<std::uint32_t>(links_[kRight].size());  // 0 without neighbours
  bool moved = false;
  if (inside_ > 0) {
    // All transit precedes all entries: an entering ray yields.
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!links_[kRight][i].entry.empty()) moved |= advance(links_[kRight][i], kRight, counters_[i], now);
      if (!links_[kLeft][i].entry.empty()) moved |= advance(links_[kLeft][i], kLeft, counters_[i], now);
    }
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!ports_[i].out_links->empty()) moved |= enter(i, now);
  }
  return moved;
}

bool Ring::advance(Link& link, Direction direction, RingCounters& counters, Cycle now) {
  if (!link.entry.can_pop(now)) return false;
  if (link.sent < cycles_per_ray_ - 1) {
    ++link.sent;
    ++counters.busy;
    return true;
  }
  const bool arrives = link.entry.front().processor == link.end;
  Fifo<RayToken>& to = arrives ? *link.arrival : link.next->entry;
  if (!to.can_push(now)) {
    ++counters.blocked;
    return false;
  }
  to.push(now, link.entry.pop(now));
  if (arrives) {
    --inside_;
    if (to.back().watched) [[unlikely]] {
      listener_->report({.step = RayStep::kArrived,
                         .cycle = now,
                         .handle = to.back().ray,
                         .processor = link.end,
                         .queue = to.back().queue});
    }
  }
  link.sent = 0;
  ++counters.busy;
  ++counters.rays[direction];
  return true;
}

bool Ring::enter(std::uint32_t processor, Cycle now) {
  Fifo<RayToken>& from = *ports_[processor].out_links;
  if (!from.can_pop(now)) return false;
  assert(from.front().processor < ports_.size() && from.front().processor != processor);
  Fifo<RayToken>& entry = links_[way(processor, from.front().processor)][processor].entry;
  if (!entry.can_push(now) || entry.room(now) < kPlacesToEnter) {
    ++counters_[processor].entry_waits;
    return false;
  }
  entry.push(now, from.pop(now));
  if (entry.back().watched) [[unlikely]] {
    listener_->report({.step = RayStep::kLinked,
                       .cycle = now,
                       .handle = entry.back().ray,
                       .processor = static_cast<int>(processor),
                       .queue = entry.back().queue,
                       .count = entry.back().processor});
  }
  ++inside_;
  ++counters_[processor].sent;
  return true;
}

Ring::Direction Ring::way(std::uint32_t from, std::uint32_t to) const {
  const auto count = static_cast<std::uint32_t>(ports_.size());
  const std::uint32_t right = to > from ? to - from : to + count - from;
  return right <= count - right ? kRight : kLeft;
}

std::uint64_t Ring::bisection_rays() const {
  const std::size_t count = ports_.size(), middle = count / 2;
  if (count < 2) return 0;
  return counters_[middle - 1].rays[kRight] + counters_[middle].rays[kLeft] + counters_[count - 1].rays[kRight] +
         counters_[0].rays[kLeft];
}

void Ring::dump(std::ostream& out) const {
  out << "ring: " << inside_ << " rays on links\n";
  for (std::size_t i = 0; i < links_[kRight].size(); ++i) {
    out << "  processor " << i << ": " << ports_[i].out_links->size() << " rays wait to enter, "
        << links_[kRight][i].entry.size() << " on the link to the right, " << links_[kLeft][i].entry.size()
        << " to the left\n";
  }
}

}  // namespace gicube::emu

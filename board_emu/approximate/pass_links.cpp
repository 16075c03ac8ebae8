// What link/ring.h does, ray by ray: a ray leaves a link when it has crossed it and there is a place for it. Times may be
// later than what is going on elsewhere; a ray without a place goes on when what is before it does.
#include <algorithm>
#include <utility>

#include "asic/link/ring.h"
#include "pass_processor.h"

namespace gicube::emu {

namespace {

constexpr std::size_t kArrivals = kFifoPlaces;  // rays between a link and the sorter

}  // namespace

PassProcessor& PassProcessor::neighbour(Direction way) const {
  const std::size_t count = shared_.processors->size();
  return *(*shared_.processors)[(number_ + (way == kRight ? 1 : count - 1)) % count];
}

// The shorter way round the ring.
PassProcessor::Direction PassProcessor::way_to(std::uint8_t processor) const {
  const std::size_t count = shared_.processors->size(), right = (processor + count - number_) % count;
  return right <= count - right ? kRight : kLeft;
}

// Rays out of the pipeline go on to their links' entries in their order.
void PassProcessor::enter_links() {
  while (!out_.empty()) {
    Crossing next = out_.front();
    const Direction way = way_to(next.to);
    Link& link = links_[way];
    const bool waited = std::exchange(out_blocked_, link.entry.size() + Ring::kPlacesToEnter > link_rays_);
    if (out_blocked_) return;
    if (waited) next.at = std::max(next.at, link.left + 1);
    out_.drop();
    if (link_stalled_ && !by_events_) line_goes_on(next.at);
    if (std::exchange(link_stalled_, false)) link_free_ = next.at + 1;
    link.entry.push(next);
    run_link(way);
  }
}

// The pipeline, and all in it, is later by as long as it was_stalled.
void PassProcessor::line_goes_on(Cycle moved) {
  link_stalled_ = false;
  const std::size_t first = out_.begin() + kLeaving - 1;  // the one for which it was_stalled
  const Cycle out = out_[first].at, was_stalled = std::max(moved + 1, out) - out;
  for (std::size_t i = first; i != out_.end(); ++i) out_[i].at += was_stalled;
  for (std::size_t i = returned_.begin(); i != returned_.end(); ++i) returned_[i].ray.ready += was_stalled;
  for (std::size_t i = std::max(arrived_, active_rays_.begin()); i != active_rays_.end(); ++i)
    active_rays_[i].ready += was_stalled;
  computing_ += was_stalled;
}

void PassProcessor::run_link(Direction way) {
  bool moved = false;
  while (pass_on(way)) moved = true;
  if (!moved) return;
  neighbour(way == kRight ? kLeft : kRight).feed_on(way);
  if (out_blocked_) enter_links();
}

// There is a place beyond the link to `way`.
void PassProcessor::feed_on(Direction way) {
  if (links_[way].blocked) run_link(way);
}

// The first ray on the link to `way`; false if it has to stay.
bool PassProcessor::pass_on(Direction way) {
  Link& link = links_[way];
  if (link.entry.empty()) return false;
  PassProcessor& next = neighbour(way);
  Crossing first = link.entry.front();
  const bool arrives = first.to == next.number_;
  const auto input = static_cast<std::size_t>(way == kRight ? From::kLeft : From::kRight);
  Link& beyond = next.links_[way];
  const bool room = arrives ? next.from_[input].size() < kArrivals : beyond.entry.size() < link_rays_;
  const bool waited = std::exchange(link.blocked, !room);
  if (!room) return false;
  link.left = std::max(first.at, link.left) + link_cycles_;
  if (waited)
    link.left = std::max(link.left, arrives ? next.taken_from_[input] - kLinkToPipeline + 1 : beyond.left + 1);
  link.entry.drop();
  ++counters_.hops;
  if (arrives) {
    first.ray.ready = link.left + kLinkToPipeline;
    next.send(static_cast<From>(input), first.ray);
  } else {
    first.at = link.left;
    beyond.entry.push(first);
    next.run_link(way);
  }
  return true;
}

}  // namespace gicube::emu

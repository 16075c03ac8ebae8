// Lookahead of a processor: how long it can run ahead, and the loops that tick it meanwhile.
#include <algorithm>

#include "asic/sorter/sorter-inl.h"
#include "cycle/traced_iteration.h"
#include "memory_port.h"
#include "processor.h"

namespace gicube::emu {

// A ray that enters the pipeline from now on cannot leave it before the returned cycle. Therefore only the rays that
// are in it, or have just left it, are examined.
Cycle Processor::lookahead_until(Cycle now) const {
  const Cycle next = now + 1;
  const Cycle line = stages_.prefetch_stages() + stages_.compute_stages();
  // It must not become empty before then, because the cause of an empty cycle depends on other parts. Carriers end
  // inside it.
  const std::size_t rays = sorter_.waiting() + issue_.size() + stages_.size() + returned_.size();
  const std::size_t outside = has_input() | out_links.size() | done.size() | overflow.size();
  if (rays < (does_more_ ? 2 * line + kMany : 1) || outside != 0 || sorter_.has_reserved_slots() ||
      splats_.has_carrier())
    return next;
  const auto others = static_cast<std::uint32_t>(stages_.size() + returned_.size());
  for (std::size_t i = 0; i < returned_.size(); ++i) {
    if (!returned_[i].has_reserved_slot && !sorter_.has_room(returned_[i].queue, others)) return next;
  }
  for (std::size_t i = 0; i < released_.size(); ++i) {
    if (sorter_.would_reserve(released_[i])) return next;
  }
  std::size_t splats = 0;
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    const InFlight& ray = stages_[i];
    const bool carries = ray.splats && splats_.waiting(splats++).carriers > 0;
    if (ray.token.has_reserved_slot && !carries) continue;
    // Earliest cycle in which it can leave.
    const Cycle out = i < stages_.computing() ? next + (ray.ready > compute_clock_ ? ray.ready - compute_clock_ : 0)
                                              : std::max(ray.ready, next) + stages_.compute_stages();
    const bool is_gone = ray.token.state == TokenStatus::kGone;
    const bool leaves = !is_gone && (ray.token.state != TokenStatus::kUnderWay || ray.token.processor != number_);
    if (leaves || carries) return out;
    if (!is_gone && !sorter_.has_room(ray.token.queue, others)) return out + 1;
    if (sorter_.would_reserve(ray.from)) return out + 1;
  }
  return next + line;
}

Cycle Processor::run_ahead(Cycle from, Cycle to, MemoryPort& memory) {
  if (can_run_active_queue()) return run_active_queue(from, to, memory);
  Cycle moved_at = 0;
  for (Cycle now = from; now < to; ++now) {
    bool moved = sorter_.tick_ahead(now);
    moved |= tick_pipeline(now);
    account(now, Cause::kLatency, 0);
    if (moved) moved_at = now;
    if (!misses_.all_sent() || !writes_.all_sent()) memory.tick_ahead(now);
  }
  return moved_at;
}

// In run_active_queue(), each FIFO between sorter and pipeline except `issue_` holds at most one item at the end of a
// cycle.
bool Processor::can_run_active_queue() const {
  return returned_.size() <= 1 && released_.size() <= 1 && has_trace_ && !does_more_ && !two_ports_ && !ideal_memory_ &&
         sorter_.may_tick_active_queue() && cache_.is_plain() && write_policy_ != v1::write_back && !frame_->jitter &&
         !frame_->wide;
}

// check_tags() for rays with a trace, in run_active_queue().
[[gnu::always_inline]] inline void Processor::iterate(Cycle now, const RayToken& issued, InFlight& entry,
                                                      MemoryPort& memory) {
  RayUnderWay& ray = rays_[issued.ray];
  Point& position = ray.ray_state.position;
  entry.ready = now + stages_.prefetch_stages();
  entry.token = issued;
  entry.from = issued.queue;
  entry.packets = 0;
  entry.splats = false;
  entry.block = ray.block;
  const Point low = grid_.low(position);
  entry.sampled = !is_skipped(ray.block, *frame_);
  if (entry.sampled) {
    cache_.for_each_miss(ray.block, cell(position, low).voxel, [&](std::uint32_t tile) {
      memory.fetch(now, partition_.home(ray.block).number, tile);
      ++entry.packets;
    });
    advance(ray.ray_state, 1, *frame_);
    ray.ray_state.set_steps_left(std::max(ray.ray_state.steps_left() - 1, 0));
    ++counts_.samples;
  } else {
    move_on(ray.ray_state, low, grid_.size(), true, *frame_, counts_);
  }
  entry.token.has_reserved_slot = false;
  if (ray.ray_state.steps_left() == 0) {
    entry.token.state = TokenStatus::kDone;
    count_end(ray.ray_state, Termination::kLeft, *frame_, counts_);
  } else if (grid_.same(position, low)) {
    entry.token.has_reserved_slot = true;
  } else {
    ray.block = static_cast<std::uint32_t>(grid_.block(position));
    const Home& home = partition_.home(ray.block);
    entry.token.processor = home.processor;
    entry.token.queue = home.number;
    entry.token.has_reserved_slot = home.processor == number_ && home.number == entry.from;
  }
}

Cycle Processor::run_active_queue(Cycle from, Cycle to, MemoryPort& memory) {
  Cycle moved_at = 0;
  const std::size_t room = cells_ ? kMaxPackets + kMaxCells : kMaxPackets, slots = stages_.prefetch_stages();
  Stages::Line line = stages_.line();
  RayToken returned = returned_.front(), issue[kFifoPlaces + 1] = {issue_.front(), issue_.back()};
  std::uint32_t released = released_.front();
  bool has_returned = !returned_.empty(), has_released = !released_.empty();
  std::size_t issued = issue_.size();
  auto returns = returned_.clock();
  auto releases = released_.clock();
  auto issues = issue_.clock();
  Cycle clock = compute_clock_;
  Cause latest = latest_;
  bool fed = false, backed_up = false, bubble = false;
  std::uint64_t held = 0;
  for (Cycle now = from; now < to; ++now) {
    const Sorter::ActiveQueueTick tick = sorter_.tick_active_queue(
        has_returned ? &returned : nullptr, has_released ? &released : nullptr, issued < kFifoPlaces, issue[issued]);
    bool moved = tick.moved;
    if (has_returned) returns.pop = now;
    if (has_released) releases.pop = now;
    const std::size_t to_enter = issued;
    if (tick.issued) {
      __builtin_prefetch(&rays_[issue[issued].ray]);
      ++issued;
      issues.push = now;
    }
    has_returned = has_released = fed = backed_up = false;
    bubble = true;
    if (issued != 0 || line.out != line.in) {
      if (line.out != line.middle && line[line.out].ready <= clock) {
        const InFlight& ray = line[line.out++];
        returned = ray.token;
        has_returned = moved = true;
        returns.push = now;
        if (!ray.token.has_reserved_slot) {
          released = ray.from;
          has_released = true;
          releases.push = now;
        }
      }
      InFlight& head = line[line.middle];
      if (line.middle != line.in && head.ready <= now) {
        bubble = false;
        moved = true;
        latest = head.sampled ? Cause::kBusy : Cause::kLeap;
        if (head.packets > 0) {
          const Packet& packet = misses_.oldest();
          if (packet.arrival > now) {
            latest = packet.sent < now ? waiting_for(packet.delay) : Cause::kMiss;
          } else {
            misses_.take();
            if (--head.packets > 0) latest = Cause::kFill;
          }
        }
        if (head.packets == 0) {
          head.ready = clock + stages_.compute_stages();
          ++line.middle;
        }
      }
      ++clock;
      if (to_enter > 0) {
        fed = line.in - line.middle < slots && misses_.room() >= room;
        backed_up = !fed;
        if (fed) {
          iterate(now, issue[0], line[line.in++], memory);
          issue[0] = issue[1];
          --issued;
          issues.pop = now;
          moved = true;
        }
      }
    }
    // Equivalent to account() while the processor holds rays.
    if (bubble) latest = unfed_[(now - slots) & unfed_mask_];
    ++causes_[static_cast<std::size_t>(latest)];
    const bool sorts = sorter_.waiting() + issued != 0;
    unfed_[now & unfed_mask_] = backed_up ? Cause::kMiss : sorts ? Cause::kSorter : Cause::kLatency;
    held += fed || sorts || line.out != line.in;
    if (moved) moved_at = now;
  }
  stages_.put_back(line);
  returned_.put_back(&returned, has_returned ? 1 : 0, returns);
  released_.put_back(&released, has_released ? 1 : 0, releases);
  issue_.put_back(issue, issued, issues);
  compute_clock_ = clock;
  latest_ = latest;
  fed_ = fed;
  backed_up_ = backed_up;
  bubble_ = bubble;
  holding_cycles_ += held;
  return moved_at;
}

}  // namespace gicube::emu

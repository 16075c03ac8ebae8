// For how long nobody round a processor has to know what it does.
#include <algorithm>

#include "asic/sorter/sorter-inl.h"
#include "cycle/known_pass.h"
#include "memory_port.h"
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

Cycle Processor::go_alone(Cycle from, Cycle to, MemoryPort& memory) {
  if (goes_round()) return go_round(from, to, memory);
  Cycle moved_at = 0;
  for (Cycle now = from; now < to; ++now) {
    bool moved = sorter_.tick_alone(now);
    moved |= tick_pipeline(now);
    account(now, Cause::kLatency, 0);
    if (moved) moved_at = now;
    if (!misses_.all_sent() || !writes_.all_sent()) memory.tick_ahead(now);
  }
  return moved_at;
}

bool Processor::goes_round() const {
  return values_are_known_ && !scatters_or_deposits_ && !two_ports_ && !ideal_memory_ && sorter_.may_tick_inside() &&
         cache_.plain_tags() != nullptr && write_policy_ != v1::write_back && !frame_->jitter && !frame_->wide;
}

// check_tags() of such a ray.
[[gnu::always_inline]] inline void Processor::pass(Cycle now, const RayToken& issued, MemoryPort& memory) {
  RayUnderWay& ray = rays_[issued.ray];
  Point& position = ray.ray_state.position;
  InFlight& entry = stages_.enter(now);
  entry.token = issued;
  entry.from = issued.queue;
  entry.packets = 0;
  entry.splats = false;
  entry.block = ray.block;
  const Point low = grid_.low(position);
  entry.sampled = !is_leapt_over(ray.block, *frame_);
  if (entry.sampled) {
    const Misses& misses = cache_.check_plain(ray.block, cell(position, low).voxel);
    if (misses.count > 0) {
      const std::uint32_t number = partition_.home(ray.block).number;
      entry.packets = static_cast<std::uint8_t>(misses.count);
      for (std::uint32_t i = 0; i < misses.count; ++i) memory.fetch(now, number, misses.tiles[i]);
    }
    advance(ray.ray_state, 1, *frame_);
    ray.ray_state.set_steps_left(std::max(ray.ray_state.steps_left() - 1, 0));
    ++counts_.samples;
  } else {
    move_on(ray.ray_state, low, grid_.size(), true, *frame_, counts_);
  }
  entry.token.keeps_slot = false;
  if (ray.ray_state.steps_left() == 0) {
    entry.token.state = TokenStatus::kDone;
    count_end(ray.ray_state, Termination::kLeft, *frame_, counts_);
  } else if (grid_.same(position, low)) {
    entry.token.keeps_slot = true;
  } else {
    ray.block = static_cast<std::uint32_t>(grid_.block(position));
    const Home& home = partition_.home(ray.block);
    entry.token.processor = home.processor;
    entry.token.queue = home.number;
    entry.token.keeps_slot = home.processor == number_ && home.number == entry.from;
  }
}

Cycle Processor::go_round(Cycle from, Cycle to, MemoryPort& memory) {
  Cycle moved_at = 0;
  const std::size_t room = cells_ ? kMaxPackets + kMaxCells : kMaxPackets;
  for (Cycle now = from; now < to; ++now) {
    bool moved = sorter_.tick_inside(now);
    fed_ = backed_up_ = bubble_ = false;
    if (!issue_.empty()) __builtin_prefetch(&rays_[issue_.back().ray]);
    if (!issue_.empty() || !stages_.empty()) {
      if (stages_.computing() > 0 && stages_.oldest_computing().ready <= compute_clock_) {
        const InFlight& ray = stages_.oldest_computing();
        returned_.push(now, ray.token);
        if (!ray.token.keeps_slot) released_.push(now, ray.from);
        stages_.leave();
        moved = true;
      }
      bubble_ = stages_.prefetching() == 0 || stages_.oldest_prefetching().ready > now;
      if (!bubble_) {
        InFlight& head = stages_.oldest_prefetching();
        latest_ = head.sampled ? Cause::kBusy : Cause::kLeap;
        if (head.packets > 0) {
          const Packet& packet = misses_.oldest();
          if (packet.arrival > now) {
            latest_ = packet.sent < now ? waiting_for(packet.delay) : Cause::kMiss;
          } else {
            misses_.take();
            if (--head.packets > 0) latest_ = Cause::kFill;
          }
        }
        if (head.packets == 0) stages_.start_computing(compute_clock_);
        moved = true;
      }
      ++compute_clock_;
      if (issue_.size() > (issue_.pushed(now) ? 1 : 0)) {
        fed_ = stages_.can_enter() & (misses_.room() >= room);
        backed_up_ = !fed_;
      }
      if (fed_) {
        pass(now, issue_.front(), memory);
        issue_.pop(now);
        moved = true;
      }
    } else {
      bubble_ = true;
    }
    account(now, Cause::kLatency, 0);
    if (moved) moved_at = now;
  }
  return moved_at;
}

}  // namespace gicube::emu

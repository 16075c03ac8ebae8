// Lookahead of a processor: how long it can run ahead, and the loops that tick it meanwhile.
#include <algorithm>

#include "asic/sorter/sorter-inl.h"
#include "datapath/interaction.h"
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
// cycle. With two rays or more, one of them is always in the queues or the pipeline.
bool Processor::can_run_active_queue() const {
  return sorter_.waiting() + issue_.size() + stages_.size() + returned_.size() > 1 && returned_.size() <= 1 &&
         released_.size() <= 1 && has_trace_ && !does_more_ && !two_ports_ && !ideal_memory_ &&
         sorter_.may_tick_active_queue() && cache_.is_plain() && write_policy_ != v1::write_back && !frame_->jitter &&
         !frame_->wide;
}

// check_tags() for rays with a trace, in run_active_queue().
[[gnu::always_inline]] inline void Processor::iterate(Cycle now, const RayToken& issued, InFlight& entry,
                                                      MemoryPort& memory) {
  RayUnderWay& ray = rays_[issued.ray];
  Point& position = ray.ray_state.position;
  const Point before = position;
  const std::uint32_t block = ray.block;
  entry.ready = now + stages_.prefetch_stages();
  entry.token = issued;
  entry.from = issued.queue;
  entry.splats = false;
  entry.block = block;
  std::uint8_t packets = 0;
  std::int32_t left = ray.ray_state.steps_left();
  entry.sampled = !is_skipped(block, *frame_);
  if (entry.sampled) [[likely]] {
    const auto voxel = [&](std::size_t axis) {
      return static_cast<std::uint32_t>(before[axis] & (grid_.size() - 1)) >> wire::kPositionFractionBits;
    };
    cache_.for_each_miss(block, {voxel(0), voxel(1), voxel(2)}, [&](std::uint32_t tile) {
      memory.fetch(now, issued.queue, tile);
      ++packets;
    });
    for (std::size_t axis = 0; axis < 3; ++axis) position[axis] += ray.ray_state.step[axis];
    left = std::max(left - 1, 0);
    ray.ray_state.set_steps_left(left);
    ++counts_.samples;
  } else {
    skip(ray.ray_state, grid_.low(before));
    left = ray.ray_state.steps_left();
  }
  entry.packets = packets;
  entry.token.has_reserved_slot = left != 0 && grid_.same(position, before);
  if (entry.token.has_reserved_slot) [[likely]]
    return;
  if (left == 0) {
    entry.token.state = TokenStatus::kDone;
    count_end(ray.ray_state, Termination::kLeft, *frame_, counts_);
    return;
  }
  ray.block = static_cast<std::uint32_t>(grid_.block(position));
  const Home& home = partition_.home(ray.block);
  entry.token.processor = home.processor;
  entry.token.queue = home.number;
}

Cycle Processor::run_active_queue(Cycle from, Cycle to, MemoryPort& memory) {
  const std::size_t room = cells_ ? kMaxPackets + kMaxCells : kMaxPackets, slots = stages_.prefetch_stages();
  Stages::Line line = stages_.line();
  RayToken returned = returned_.front(), issue[kFifoPlaces + 1] = {issue_.front(), issue_.back()};
  std::uint32_t released = released_.front();
  bool has_returned = !returned_.empty(), has_released = !released_.empty();
  std::size_t issued = issue_.size();
  // The cycle in which the oldest computing ray leaves, and that from which on the oldest prefetched one may compute.
  // Within the loop nothing stalls the compute stages, so their clock only lags by the cycles without rays.
  Cycle lag = from - compute_clock_, moved_at = 0;
  const auto next_leave = [&] { return line.out == line.middle ? kNoCycle : line[line.out].ready + lag; };
  const auto next_start = [&] { return line.middle == line.in ? kNoCycle : line[line.middle].ready; };
  Cycle leaves = next_leave(), starts = next_start();
  Cause latest = latest_;
  for (Cycle now = from; now < to; ++now) {
    const std::size_t to_enter = issued;
    bool moved = sorter_.tick_active_queue(has_returned ? &returned : nullptr, has_released ? &released : nullptr,
                                           issue, issued);
    if (issued > to_enter) __builtin_prefetch(&rays_[issue[to_enter].ray]);
    if (issued == 0 && line.out == line.in) ++lag;
    const bool bubble = starts > now;
    has_returned = has_released = false;
    if (leaves <= now) {
      const InFlight& ray = line[line.out++];
      returned = ray.token;
      has_returned = moved = true;
      released = ray.from;
      has_released = !ray.token.has_reserved_slot;
      leaves = next_leave();
    }
    if (!bubble) {
      InFlight& head = line[line.middle];
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
        head.ready = now - lag + stages_.compute_stages();
        ++line.middle;
        starts = next_start();
        leaves = std::min(leaves, head.ready + lag);
      }
    }
    const bool fed = to_enter > 0 && line.in - line.middle < slots && misses_.room() >= room;
    if (fed) {
      iterate(now, issue[0], line[line.in], memory);
      ++line.in;
      starts = std::min(starts, now + slots);
      issue[0] = issue[1];
      --issued;
      moved = true;
    }
    // Equivalent to account() while the processor holds rays.
    if (bubble) latest = unfed_[(now - slots) & unfed_mask_];
    ++causes_[static_cast<std::size_t>(latest)];
    const Cause unfed = sorter_.waiting() != 0 || issued != 0 ? Cause::kSorter : Cause::kLatency;
    if (!fed) unfed_[now & unfed_mask_] = to_enter > 0 ? Cause::kMiss : unfed;
    if (moved) moved_at = now;
  }
  stages_.put_back(line);
  returned_.put_back(&returned, has_returned ? 1 : 0);
  released_.put_back(&released, has_released ? 1 : 0);
  issue_.put_back(issue, issued);
  compute_clock_ = to - lag;
  latest_ = latest;
  holding_cycles_ += to - from;
  return moved_at;
}

}  // namespace gicube::emu

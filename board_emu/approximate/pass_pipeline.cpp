// A processor's passes: from the sorter through the pipeline and back, or out of the processor.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "pass_processor.h"

namespace gicube::emu {

// As the sorter's queues count it, at least 1.
std::uint64_t PassProcessor::contribution_of(const QueuedRay& ray) const {
  const PassRay& of_ray = (*shared_.rays)[ray.ray];
  const auto last = std::max<float>(1, of_ray.next_contribution), first = std::max<float>(last, of_ray.contribution);
  const float to_go = static_cast<float>(ray.left) / static_cast<float>(std::max(1, of_ray.steps));
  return static_cast<std::uint64_t>(last * std::pow(first / last, to_go));
}

void PassProcessor::put(const QueuedRay& ray, std::size_t block) {
  PassRay& to = (*shared_.rays)[ray.ray];
  to.position = unpacked(ray.at);
  to.left = ray.left;
  to.block = static_cast<std::uint32_t>(block);
}

// Counts rays that come (+1) and go (-1).
void PassProcessor::hold(int rays, Cycle when) {
  if (holds_ == 0) held_since_ = std::max(when, held_until_);
  holds_ += static_cast<std::uint64_t>(rays);
  if (holds_ != 0 || when <= held_since_) return;
  counters_.held += when - held_since_;
  held_until_ = when;
}

// A ray at its last step needs a place in the tree, which may come to be free at a time that is not known yet.
bool PassProcessor::finds_place() {
  if (in_tree_ + 1 <= tree_places_ / 2) return true;
  stalled_ = in_tree_ >= tree_places_;
  if (!stalled_ && tree_free_ > compute_) computing_ = std::max(computing_, tree_free_ - compute_);
  return !stalled_;
}

// When a packet can be written into the cache, of whose data the last came in that clock.
Cycle PassProcessor::arrival(Cycle data_end) const { return to_core_.from(data_end + memory_latency_); }

// When the packets are there of a sample that could be resampled in cycle `first`: each is written in a cycle of its own,
// and the last is handed on in that cycle.
Cycle PassProcessor::fetch(const Misses& misses, Cycle first) {
  if (ideal_memory_) return first;
  PassMemory& memory = *shared_.memory;
  for (std::uint32_t i = 0; i < misses.count; ++i) {
    memory.asked = std::max(memory.asked, now_) + 1;
    const Cycle there =
        arrival(memory.channel->read(in_memory(active_), misses.tiles[i], to_memory_.from(memory.asked)).data_end);
    first = std::max(i == 0 ? first : first + 1, there);
    taken_[packets_++ % kRemembered] = first;
  }
  return first;
}

void PassProcessor::release(std::uint32_t queue, Cycle out) {
  const Cycle when = out + kPipelineToPipeline;
  if (overflowed_[queue] > 0) {
    --overflowed_[queue];
    keep_slot(queue, when);
    return;
  }
  released_.push({when, queue});
  if (waits_[0] || waits_[1] || waits_[2]) others_ = std::min(others_, when);
}

// A ray of that queue is at its end when it comes out of the pipeline in cycle `out`.
void PassProcessor::finish(std::uint32_t handle, std::uint32_t queue, Cycle out) {
  release(queue, out);
  hold(-1, out);
  shared_.up->push(number_, {out + to_dsp_, handle, 0, Arrival::Kind::kRay, number_});
  ++in_tree_;
}

// The block of a place that is `at` from that one's corner.
std::uint32_t PassProcessor::block_at(std::uint32_t block, const Point& at) const {
  const auto blocks = [&](std::size_t axis) { return static_cast<std::uint32_t>(at[axis] >> block_shift_); };
  return block + blocks(0) + across_ * blocks(1) + slice_ * blocks(2);
}

// A ray of that queue has come out of its block, to `at` from its corner.
void PassProcessor::change_block(QueuedRay ray, std::uint32_t queue, std::uint32_t from, Point at, Cycle out) {
  const std::uint32_t block = block_at(from, at);
  for (std::int32_t& coordinate : at) coordinate &= grid_.size() - 1;
  ray.at = packed(at);
  const Home& home = shared_.partition->home(block);
  const bool keeps_slot = home.processor == number_ && home.number == queue;
  if (!keeps_slot) release(queue, out);
  if (home.processor == number_) {
    ray.ready = out + kPipelineToPipeline;
    comes_back({ray, home.number, keeps_slot});
    return;
  }
  put(ray, block);
  hold(-1, out);
  ++counters_.rays_sent;
  out_.push({out + 1, home.processor, {0, ray.ray, home.number}});
  if (!out_blocked_) enter_links();
}

// What a drawn step is drawn from: the words of drawn_from().
struct DrawnFrom {
  std::array<std::int16_t, 3> direction;
  std::uint16_t u, v, unused;
};

// A jittered step's, 16.16 voxels. `corner`: of the ray's block.
std::uint32_t PassProcessor::distance_of(const QueuedRay& ray, const Point& corner) const {
  const auto words = std::bit_cast<DrawnFrom>((*shared_.rays)[ray.ray].step);
  Point position = unpacked(ray.at);
  for (std::size_t axis = 0; axis < 3; ++axis) position[axis] += corner[axis];
  return jittered(*frame_, jitter(position, words.u, words.v));
}

Point PassProcessor::step_of(const QueuedRay& ray, const Point& corner) const {
  const PassRay& words = (*shared_.rays)[ray.ray];
  if (jitter_) return step_vector(std::bit_cast<DrawnFrom>(words.step).direction, distance_of(ray, corner));
  if (!short_steps_) return words.step;
  // What a field borrowed from is added to it again.
  const auto field = [](std::uint64_t from) {
    return static_cast<std::int32_t>(static_cast<std::int64_t>(from << (64 - kField)) >> (64 - kField));
  };
  const std::int32_t x = field(ray.step);
  const std::uint64_t above = (ray.step - static_cast<std::uint64_t>(std::int64_t{x})) >> kField;
  const std::int32_t y = field(above);
  return {x, y, field((above - static_cast<std::uint64_t>(std::int64_t{y})) >> kField)};
}

FinePoint PassProcessor::fine_step_of(const QueuedRay& ray, const Point& corner) const {
  const PassRay& words = (*shared_.rays)[ray.ray];
  if (!jitter_) return fine(words.step, words.step_rest);
  return fine_step_vector(std::bit_cast<DrawnFrom>(words.step).direction, distance_of(ray, corner));
}

// Where a ray is after a step that is its own; `rest`: on the wide datapath, what it then has below a unit.
inline std::uint64_t PassProcessor::next_place(const QueuedRay& ray, Rest& rest) const {
  if (!wide_) return ray.at + packed(step_of(ray, corner_));
  const FinePoint to = moved(fine(unpacked(ray.at), (*shared_.rays)[ray.ray].rest), fine_step_of(ray, corner_), 1);
  rest = rest_of(to);
  return packed(units_of(to));
}

// Whether its last step takes it to the DSP.
bool PassProcessor::goes_to_dsp(std::uint32_t handle) const {
  const PassRoute* route = (*shared_.rays)[handle].route.get();
  if (route == nullptr) return true;
  return !route->carrier && (route->events[route->next].ends || route->events[route->next].trapped);
}

// One pass of the first ray, which leaps or may not come back to its queue; sets now_ to the cycle in which it enters the
// pipeline. False if the pipeline stalls instead.
bool PassProcessor::pass_out(Cycle& now) {
  if ((active_rays_.front().left == 1 && !finds_place()) || stalls_for_link(now)) {
    arrive(now, now);
    return false;
  }
  QueuedRay ray = active_rays_.pop();
  before_ = now;
  // The prefetch line is as long as it is, and has room for the packets of a sample. Zeroes stand for what was not.
  now_ = std::max({now, started_[(passes_ - prefetch_) % kRemembered], oldest_taken()});
  now = now_ + 1;
  Cycle computing = std::max(computing_ + 1, now_ + prefetch_);
  const bool wide = wide_;
  PassRay& of_ray = (*shared_.rays)[ray.ray];
  Rest& rest = of_ray.rest;
  const Point step = wide ? Point{} : step_of(ray, corner_);
  const FinePoint fine_step = wide ? fine_step_of(ray, corner_) : FinePoint{};
  Point at = unpacked(ray.at);
  const FinePoint from = wide ? fine(at, rest) : FinePoint{};
  std::int32_t steps = 1;
  if (empty_ != nullptr && empty_[block_] != 0) {
    ++counters_.leaps;
    const std::int32_t out_of_block =
        wide ? leap_steps(from, fine_step, FinePoint{}, std::int64_t{grid_.size()} << kRestBits)
             : leap_steps(at, step, Point{}, grid_.size());
    steps = std::min(out_of_block, ray.left);
  } else {
    computing = fetch(cache_.check(block_, cell(at, Point{}).voxel), computing);
  }
  computing_ = computing;
  started_[passes_++ % kRemembered] = computing_;
  if (wide) {
    const FinePoint to = moved(from, fine_step, steps);
    at = units_of(to);
    rest = rest_of(to);
  } else {
    for (std::size_t axis = 0; axis < 3; ++axis) at[axis] += steps * step[axis];
  }
  ray.left -= steps;
  const Cycle out = last_out_ = computing_ + compute_;
  if (ray.left <= 0) {
    finish(ray.ray, active_, out);
  } else if ((at[0] | at[1] | at[2]) >> block_shift_ != 0) {
    change_block(ray, active_, block_, at, out);
  } else {
    ray.at = packed(at);
    ray.ready = out + kPipelineToPipeline;
    active_rays_.push(ray);
  }
  return true;
}

// When the first of those that were not of the active queue, and now are, is back.
Cycle PassProcessor::own_return() const {
  if (returning_[active_] == 0) return kNoCycle;
  std::size_t first = returned_.begin();
  while (returned_[first].queue != active_) ++first;
  return returned_[first].ray.ready;
}

// Turns of the active queue's rays one after the other, until it is empty or something else happens. In most a ray takes a step
// within the block and comes back, and nothing is asked for; what they change is kept in registers.
template <bool kAlike, bool kPlain>
void PassProcessor::rotate(Cycle& ends, Cycle until) {
  const std::uint32_t* const tags = cache_.plain_tags();
  const std::uint32_t block = block_;
  const bool leaps = empty_ != nullptr && empty_[block] != 0;
  const std::uint64_t both = block * 0x1'0000'0001u, first_only = ~0u;
  const std::size_t tiles_x = cache_.tiles_x(), slice = tiles_x * tiles_x;
  constexpr int kVoxel = wire::kPositionFractionBits;
  const std::uint64_t leaving = outside_;
  const Cycle come_back = compute_ + kPipelineToPipeline, prefetch = prefetch_;
  while (!active_rays_.empty()) {
    // How far it may go: until something comes. What returns to other queues can wait.
    const Cycle last = std::min({until, others_ - 1, own_return() - 1});
    QueuedRay* const places = active_rays_.places();
    const std::size_t mask = active_rays_.mask(), size = active_rays_.size(), begin = active_rays_.begin();
    std::size_t first = begin;
    const std::uint64_t passes = passes_ - begin;
    Cycle now = ends, computing = computing_, entered = now_, taken = oldest_taken(), before = before_;
    bool goes_out = leaps || out_.size() > kLeaving;
    for (; now <= last; ++first) {
      const QueuedRay& ray = places[first & mask];
      if (ray.ready > now) break;
      const std::uint64_t at = ray.at, step = ray.step;
      [[maybe_unused]] Rest rest{};
      const std::uint64_t to = kAlike ? at + step : next_place(ray, rest);
      goes_out = goes_out || (to & leaving) != 0 || ray.left == 1;
      const Cycle enters = std::max({now, started_[(passes + first - prefetch) % kRemembered], taken});
      const Cycle computes = std::max(computing + 1, enters + prefetch);
      if (goes_out) break;
      bool there = false;
      if constexpr (kPlain) {
        const std::size_t row = -(at >> (kField + kVoxel) & 1) & tiles_x;
        const std::size_t x = at >> (kVoxel + 1) & 31, y = at >> (kField + kVoxel + 1) & 31,
                          z = at >> (2 * kField + kVoxel);
        const std::uint32_t* const tile = tags + (z * tiles_x + y) * tiles_x + x;
        const auto differs = [both](const std::uint32_t* of) {
          std::uint64_t pair = 0;
          std::memcpy(&pair, of, sizeof pair);
          return pair ^ both;
        };
        const std::uint64_t any =
            differs(tile) | differs(tile + row) | differs(tile + slice) | differs(tile + slice + row);
        there = (any & (first_only | -(at >> kVoxel & 1))) == 0;
      } else {
        there = cache_.latest(block, cell(unpacked(at), Point{}).voxel);
      }
      before = now;
      entered = enters;
      now = entered + 1;
      computing = computes;
      if (!there) {
        now_ = entered;
        computing = fetch(cache_.ask(block, cell(unpacked(at), Point{}).voxel), computing);
        taken = oldest_taken();
      }
      started_[(passes + first) % kRemembered] = computing;
      if constexpr (!kAlike) {
        if (wide_) (*shared_.rays)[ray.ray].rest = rest;
      }
      places[(first + size) & mask] = {to, step, computing + come_back, ray.ray, ray.left - 1};
    }
    active_rays_.rotated(first - begin);
    passes_ = passes + first;
    computing_ = computing;
    now_ = entered;
    before_ = before;
    ends = now;
    goes_out = goes_out && now <= last && active_rays_.front().ready <= now;
    if (!goes_out || !pass_out(ends)) return;
  }
}

template void PassProcessor::rotate<false, false>(Cycle&, Cycle);
template void PassProcessor::rotate<false, true>(Cycle&, Cycle);
template void PassProcessor::rotate<true, false>(Cycle&, Cycle);
template void PassProcessor::rotate<true, true>(Cycle&, Cycle);

}  // namespace gicube::emu

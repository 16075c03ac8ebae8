#include "pass_processor.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace gicube::emu {

namespace {

constexpr auto kBus = static_cast<std::size_t>(PassProcessor::From::kBus);

}  // namespace

PassProcessor::PassProcessor(std::uint8_t number, const Shared& shared)
    : number_(number),
      shared_(shared),
      prefetch_(shared_.config->pipeline().prefetch_stages()),
      compute_(shared_.config->pipeline().compute_stages()),
      capacity_(shared_.config->ideal().queues() != 0 ? kNone : shared_.config->asic().queue_rays()),
      sharing_(memory_standard(*shared_.config).sharing),
      to_memory_(shared_.config->asic().core_khz(), memory_standard(*shared_.config).clock_khz),
      to_core_(memory_standard(*shared_.config).clock_khz, shared_.config->asic().core_khz()),
      room_(shared_.config->cache().miss_packets() -
            (shared_.config->cache().irradiance() == v1::in_cells ? 2 : 1) * Misses::kMax),
      link_cycles_((wire::kRayBits + shared_.config->link().bits() - 1) / shared_.config->link().bits()),
      link_rays_(shared_.config->link().rays()),
      memory_latency_(memory_standard(*shared_.config).latency),
      to_dsp_(std::bit_width(2 * shared_.config->asic().processors() - 1) + 1u),
      tree_places_(2 * static_cast<std::uint32_t>(to_dsp_)),
      ideal_memory_(shared_.config->ideal().memory() != 0),
      writes_all_voxels_(shared_.config->cache().splat_rule() != v1::whole_units),
      writes_back_(shared_.config->cache().write_policy() == v1::write_back),
      combines_(shared_.config->cache().write_policy() != v1::write_through),
      queues_(std::max<std::size_t>(1, shared_.partition->blocks_of(number))),
      slots_(queues_.size()),
      overflowed_(queues_.size()),
      importance_(static_cast<std::uint32_t>(queues_.size())),
      importance_of_(emu::importance_of(shared_.config->sorter().policy())),
      by_contribution_(reads_contribution(shared_.config->sorter().policy())),
      contributions_(queues_.size()),
      ideal_sorter_(shared_.config->ideal().sorter() != 0),
      opened_(queues_.size()),
      listed_(queues_.size()),
      returning_(queues_.size()),
      cache_({static_cast<int>(shared_.config->asic().block_voxels()), shared_.config->cache().ways(), false,
              shared_.blocks, writes_back_, 1, shared_.config->cache().tags() == v1::of_voxels}),
      cells_(shared_.config->cache().irradiance() == v1::in_cells
                 ? std::optional<VolumeCache>(CacheShape{static_cast<int>(shared_.config->asic().block_voxels()),
                                                         shared_.config->cache().ways(), false, shared_.blocks,
                                                         writes_back_, 2})
                 : std::nullopt),
      two_ports_(shared_.config->cache().ports() == 2),
      splat_cycles_(two_ports_ ? 1 : 2),
      writes_(shared_.config->cache().write_packets()) {}

bool PassProcessor::goes_by_events(const v1::BoardConfig& config, const Frame& frame) {
  const v1::IdealConfig& ideal = config.ideal();
  return !frame.plain() || config.cache().ports() == 2 || memory_standard(config).sharing > 1 ||
         ideal.memory() + ideal.queues() + ideal.sorter() + ideal.dsp() > 0;
}

void PassProcessor::begin(Cycle now, const Frame& frame) {
  now_ = std::max(now_, now);
  computing_ = std::max(computing_, now);
  frame_ = &frame;
  jitter_ = frame.jitter;
  wide_ = frame.wide;
  by_events_ = goes_by_events(*shared_.config, frame);
  leaves_sums_ = frame.sums != nullptr;
  stood_ = 0;
  short_steps_ = frame.step < kLongStep;  // of finer units than positions: those that are have room to spare
  const bool plain = cache_.plain_tags() != nullptr;
  const bool alike = !jitter_ && !wide_;
  rotate_ = alike ? (plain ? &PassProcessor::rotate<true, true> : &PassProcessor::rotate<true, false>)
                  : (plain ? &PassProcessor::rotate<false, true> : &PassProcessor::rotate<false, false>);
  if (by_events_) rotate_ = &PassProcessor::rotate_line;
  empty_ = frame.leap ? frame.empty.data() : nullptr;
  grid_ = BlockGrid(*frame.volume);
  packs_steps_ = alike && short_steps_;
  const std::uint64_t outside = ((1u << kField) - 1) & ~static_cast<std::uint64_t>(grid_.size() - 1);
  outside_ = outside | outside << kField | outside << 2 * kField;
  block_shift_ = std::countr_zero(static_cast<std::uint32_t>(grid_.size()));
  across_ = static_cast<std::uint32_t>(frame.volume->blocks()[0]);
  slice_ = across_ * static_cast<std::uint32_t>(frame.volume->blocks()[1]);
  if (active_ != kNone) find_block();  // of the frame before
}

// What was_stalled goes on when the place that is free has come down the tree.
void PassProcessor::taken_from_tree(Cycle now) {
  --in_tree_;
  const bool waits = waits_[0] || waits_[1] || waits_[2];
  if (!std::exchange(stalled_, false) && !waits) return;
  tree_free_ = now + to_dsp_;
  if (waits) others_ = std::min(others_, tree_free_);
}

// Slots that were given up are only counted when one is needed.
inline bool PassProcessor::has_slot(std::uint32_t queue, Cycle now) {
  if (slots_[queue] < capacity_) return true;
  while (!released_.empty() && released_.front().first <= now) {
    const std::uint32_t given_up = released_.pop().second;
    if (given_up != kNone) --slots_[given_up];
  }
  return slots_[queue] < capacity_;
}

// False if there is none: the ray goes to the DSP.
inline bool PassProcessor::take_slot(std::uint32_t handle, std::uint32_t queue, Cycle ready) {
  if (has_slot(queue, ready)) {
    ++slots_[queue];
    return true;
  }
  overflow(handle, queue, ready);
  return false;
}

// The first slot that the queue gives up is kept for it. It may be known already when that will be.
void PassProcessor::overflow(std::uint32_t handle, std::uint32_t queue, Cycle ready) {
  ++counters_.overflows;
  ++in_tree_;
  shared_.up->push(number_, {ready - kSorterToPipeline + to_dsp_, handle, queue, Arrival::Kind::kOverflowed, number_});
  for (std::size_t i = released_.begin(); i != released_.end(); ++i) {
    if (released_[i].second != queue) continue;
    released_[i].second = kNone;
    keep_slot(queue, released_[i].first);
    return;
  }
  ++overflowed_[queue];
}

// A slot that is given up so that it can be taken in cycle `when` stays taken, and the DSP is told.
void PassProcessor::keep_slot(std::uint32_t queue, Cycle when) {
  ++in_tree_;
  shared_.up->push(number_, {when - kSorterToPipeline + to_dsp_, 0, queue, Arrival::Kind::kSlot, number_});
}

// Into its queue, when it is ready.
inline void PassProcessor::write(const QueuedRay& ray, std::uint32_t queue) {
  if (queue == active_) {
    if (by_events_ || !stalled())
      arrive(ray.ready, ray.ready);  // else it is not known when those in the pipeline are back
    active_rays_.insert(arrived_++, ray);
    return;
  }
  if (queues_[queue].empty()) opened_[queue] = ++openings_;
  queues_[queue].push(ray);
  if (by_contribution_) contributions_[queue] += contribution_of(ray);
  ++waiting_;
  if (listed_[queue] != 0) return;
  listed_[queue] = 1;
  modified_.push(queue);
}

// What has come from elsewhere by now, as far as there is room beside `returned` rays in so many `cycles`: two are written a
// cycle, but not to one queue [P §3.2]. A ray that must wait holds up what is behind it.
void PassProcessor::take_others(Cycle now, Cycle cycles, Cycle returned, std::uint32_t written) {
  Cycle room = 2 * cycles - returned, beside = cycles - returned;  // of all, and of those for the same queue
  const auto comes = [&](std::size_t input) { return !from_[input].empty() && from_[input].front().ready <= now; };
  std::array<Cycle, 3> taken{};
  for (std::uint32_t tried = 0; tried < from_.size(); ++tried, next_input_ = (next_input_ + 1) % 3) {
    waits_[next_input_] = comes(next_input_);
    if (!waits_[next_input_]) continue;
    LongQueue<Arrival>& from = from_[next_input_];
    const bool own = from.front().kind == Arrival::Kind::kToItsSlot;
    const bool slot = own || has_slot(from.front().queue, now), same = from.front().queue == written && slot;
    if (taken[next_input_] == cycles) continue;
    if (room == 0 || (same && beside == 0)) {
      others_ = room == 0 ? now + 1 : next_gap(now);
      ++counters_.conflicts;
      waits_[kBus] = comes(kBus);
      return;
    }
    if (!slot && (in_tree_ >= tree_places_ || now < tree_free_)) continue;
    if (written == kNone || same) {
      written = from.front().queue;
      --beside;
    }
    --room;
    ++taken[next_input_];
    tried = kNone;  // all once more
    const Arrival ray = from.pop();
    if (own || take_slot(ray.ray, ray.queue, ray.ready)) {
      write(queued_ray(ray.ray, ray.ready), ray.queue);
      hold(1, ray.ready);
    }
    taken_from_[next_input_] = now;
    if (next_input_ == static_cast<std::uint32_t>(From::kLeft)) neighbour(kLeft).feed_on(kRight);
    if (next_input_ == static_cast<std::uint32_t>(From::kRight)) neighbour(kRight).feed_on(kLeft);
  }
  others_ = kNoCycle;
  for (std::size_t i = 0; i < from_.size(); ++i) {
    if (!from_[i].empty())
      others_ = std::min(others_, taken[i] == cycles ? now + 1 : waits_[i] ? retry(now) : from_[i].front().ready);
  }
}

// The first cycle after `now` in which no ray comes back to the active queue, as far as it is known.
Cycle PassProcessor::next_gap(Cycle now) {
  Cycle gap = now + 1;
  for (std::size_t i = std::max(arrived_, active_rays_.begin());
       i != active_rays_.end() && active_rays_[i].ready == gap; ++i)
    ++gap;
  return gap;
}

// When a ray without a slot may be tried again, as far as it is known.
Cycle PassProcessor::retry(Cycle now) const {
  const Cycle slot = released_.empty() ? kNoCycle : released_.front().first;
  const Cycle tree = in_tree_ < tree_places_ ? tree_free_ : kNoCycle;
  return std::max(now + 1, std::min(slot, tree));
}

// The sorter's insertions up to now. It made them on the way, but nobody asks before a queue is chosen.
inline void PassProcessor::take_in(Cycle now) {
  Cycle cycles = now - sorted_;
  sorted_ = now;
  while (cycles > 0 && !modified_.empty()) {
    const std::uint32_t queue = modified_.pop();
    listed_[queue] = 0;
    if (queues_[queue].empty()) continue;
    importance_.set(queue, importance_of_({.waiting = static_cast<std::uint32_t>(queues_[queue].size()),
                                           .opened = opened_[queue],
                                           .contribution = contributions_[queue]}));
    cycles -= ideal_sorter_ ? 0 : 1;
  }
}

// The active queue gives way when it is empty. False if no ray waits.
inline bool PassProcessor::choose(Cycle now) {
  const bool waits = !active_rays_.empty() && active_rays_.front().ready <= now;
  if (waits && !resting_) return true;
  resting_ = true;
  take_in(now);
  const std::uint32_t most = waiting_ > 0 ? importance_.importance() : 0;
  if (waits) {
    arrive(now, now);
    const auto rays = static_cast<std::uint32_t>(arrived_ - active_rays_.begin());
    std::uint64_t contribution = 0;
    for (std::size_t i = active_rays_.begin(); by_contribution_ && i != arrived_; ++i)
      contribution += contribution_of(active_rays_[i]);
    const std::uint32_t own = importance_of_({.waiting = rays, .opened = openings_ + 1, .contribution = contribution});
    resting_ = own < most || (own == most && active_ > importance_.queue());
  }
  if (resting_ && most == 0) return false;
  if (resting_) activate(importance_.queue(), now);
  resting_ = false;
  ++counters_.activations;
  return true;
}

// That of the active queue.
void PassProcessor::find_block() {
  block_ = static_cast<std::uint32_t>(shared_.partition->block(number_, active_));
  corner_ = grid_.corner(block_);
  for (std::int32_t& at : corner_) at <<= wire::kPositionFractionBits;
}

void PassProcessor::activate(std::uint32_t queue, Cycle now) {
  if (!active_rays_.empty()) put_back(now);
  active_ = queue;
  importance_.set(queue, 0);
  LongQueue<QueuedRay>& from = queues_[queue];
  waiting_ -= from.size();
  contributions_[queue] = 0;
  find_block();
  while (!from.empty()) {
    active_rays_.push(from.pop());
    active_rays_[active_rays_.end() - 1].ready = now;
  }
  arrived_ = active_rays_.end();
}

// The rays of the queue that was active: those that wait to their queue, and those in the pipeline to those on their way back.
void PassProcessor::put_back(Cycle now) {
  arrive(now, now);
  const std::uint32_t queue = std::exchange(active_, kNone);
  for (; active_rays_.begin() != arrived_; active_rays_.drop()) write(active_rays_.front(), queue);
  returning_[queue] += static_cast<std::uint32_t>(active_rays_.size());
  // Few of the others are back later than the first of these: those are merged from behind.
  std::size_t other = returned_.end();
  for (std::size_t i = active_rays_.begin(); i != active_rays_.end(); ++i) returned_.push({});
  std::size_t place = returned_.end();
  for (std::size_t i = active_rays_.end(); i != active_rays_.begin();) {
    const QueuedRay& ray = active_rays_[--i];
    for (; other != returned_.begin() && returned_[other - 1].ray.ready >= ray.ready; --other) {
      returned_[--place] = returned_[other - 1];
    }
    returned_[--place] = {ray, queue, true};
  }
  active_rays_.clear();
}

PassProcessor::QueuedRay PassProcessor::queued_ray(std::uint32_t handle, Cycle ready) const {
  const PassRay& ray = (*shared_.rays)[handle];
  return {packed(ray.position), packed(field_step(ray.step)), ready, handle, ray.left};
}

// How many rays of the active queue have come back from after `before` to `now`.
Cycle PassProcessor::arrive(Cycle now, Cycle before) {
  Cycle count = 0;
  for (arrived_ = std::max(arrived_, active_rays_.begin());
       arrived_ != active_rays_.end() && active_rays_[arrived_].ready <= now; ++arrived_) {
    count += active_rays_[arrived_].ready > before ? 1 : 0;
  }
  return count;
}

// What is back from the pipeline by now, for other queues; returns how many came after `since`, and `written` is the queue
// of the last of them.
Cycle PassProcessor::take_returned(Cycle now, Cycle since, std::uint32_t& written) {
  Cycle count = 0;
  for (; !returned_.empty() && returned_.front().ray.ready <= now; returned_.drop()) {
    const Returning& next = returned_.front();
    if (next.ray.ready > since) {
      written = next.queue;
      ++count;
    }
    --returning_[next.queue];
    if (next.keeps_slot || take_slot(next.ray.ray, next.queue, next.ray.ready)) {
      write(next.ray, next.queue);
    } else {
      put(next.ray, shared_.partition->block(number_, next.queue));
      hold(-1, next.ray.ready);
    }
  }
  return count;
}

void PassProcessor::work(Cycle until, bool bus_waits) {
  const std::size_t on_the_bus = from_bus();
  Cycle now = next();
  while (true) {
    const bool was_stalled = line_stands() && !by_events_;  // times of what is in the pipeline may change
    if (!was_stalled && !resting_) (this->*rotate_)(now, until);
    if (by_events_) run_line(std::min(now, until));
    std::uint32_t written = kNone;
    if (now > until) {
      if (!stalled()) take_returned(until, until, written);
      return;
    }
    // The sorter's cycles since the first of the others could have been taken.
    const Cycle since = std::max(before_, std::min(others_, now) - 1);
    Cycle returned = was_stalled ? 0 : take_returned(now, since, written);
    if (others_ <= now) {
      const Cycle back = was_stalled ? 0 : arrive(now, since);
      if (back > 0) written = active_;
      returned += back;
      take_others(now, std::max(now - since, returned), returned, written);
    }
    before_ = now;
    if (stalled() || !choose(now)) now = std::max(now + 1, next());
    if (bus_waits && from_bus() < on_the_bus) return;
  }
}

}  // namespace gicube::emu

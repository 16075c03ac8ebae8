#include "turn_processor.h"

#include <algorithm>
#include <bit>

namespace gicube::emu {

namespace {

constexpr std::uint32_t kMostPackets = 8;  // of one neighbourhood
constexpr Cycle kToQueue = 4;              // from the end of the pipeline by four registers to its beginning
constexpr Cycle kToDsp = 4;                // through the merge tree
constexpr Cycle kOverRing = 1;             // into the sorter behind a link
constexpr std::uint32_t kRayBits = 256;

}  // namespace

TurnProcessor::TurnProcessor(std::uint8_t number, const Surroundings& surroundings)
    : number_(number),
      with_(surroundings),
      prefetch_(with_.config->pipeline().prefetch_stages()),
      compute_(with_.config->pipeline().compute_stages()),
      capacity_(with_.config->ideal().queues() != 0 ? kNone : with_.config->asic().queue_rays()),
      ratio_(with_.config->rdram().clocks_per_core_cycle()),
      ratio_bits_(std::has_single_bit(ratio_) ? std::countr_zero(ratio_) : -1),
      room_(with_.config->cache().miss_packets() - kMostPackets),
      link_cycles_((kRayBits + with_.config->link().bits() - 1) / with_.config->link().bits()),
      rac_latency_(with_.config->rdram().rac_latency()),
      ideal_memory_(with_.config->ideal().memory() != 0),
      queues_(std::max<std::size_t>(1, with_.partition->blocks_of(number))),
      slots_(queues_.size()),
      most_(static_cast<std::uint32_t>(queues_.size())),
      listed_(queues_.size()),
      cache_(
          {static_cast<int>(with_.config->asic().block_voxels()), with_.config->cache().ways(), false, with_.blocks}) {}

void TurnProcessor::begin(Cycle now, const Frame& frame) {
  now_ = std::max(now_, now);
  computing_ = std::max(computing_, now);
  frame_ = &frame;
  grid_ = BlockGrid(*frame.volume);
}

Cycle TurnProcessor::next() const {
  if (waiting_ > 0) return now_ + 1;
  const Cycle first = std::min(returned_.empty() ? kNoCycle : returned_.front().ready, others_);
  return first == kNoCycle ? first : std::max(first, now_ + 1);
}

// Counts rays that come (+1) and go (-1).
inline void TurnProcessor::hold(int rays, Cycle when) {
  if (holds_ == 0) held_since_ = when;
  holds_ += static_cast<std::uint64_t>(rays);
  if (holds_ == 0) counters_.held += std::max(when, held_since_) - held_since_;
}

// Slots that were given up are only counted when one is needed.
inline bool TurnProcessor::has_slot(std::uint32_t queue, Cycle now) {
  if (slots_[queue] < capacity_) return true;
  while (!released_.empty() && released_.front().first <= now) --slots_[released_.pop().second];
  return slots_[queue] < capacity_;
}

inline void TurnProcessor::write(const Coming& ray) {
  if (!ray.keeps_slot) {
    if (!has_slot(ray.queue, ray.ready)) {
      ++counters_.overflows;
      with_.up->push({ray.ray, ray.ready + kToDsp, 0, false, true});
      return;
    }
    ++slots_[ray.queue];
  }
  queues_[ray.queue].push(ray.ray);
  ++waiting_;
  ++counters_.written;
  if (ray.queue == active_ || listed_[ray.queue] != 0) return;
  listed_[ray.queue] = 1;
  modified_.push(ray.queue);
}

// What has come from elsewhere by now, as far as there is room beside `returned` rays in so many `cycles`: two are written a
// cycle, but not to one queue [P §3.2]. A ray that must wait holds up what is behind it.
void TurnProcessor::take_others(Cycle now, Cycle cycles, Cycle returned, std::uint32_t written) {
  Cycle room = 2 * cycles - returned, beside = cycles - returned;  // of all, and of those for the same queue
  for (std::size_t tried = 0; tried < from_.size(); ++tried) {
    LongQueue<Coming>& from = from_[turn_];
    while (!from.empty() && from.front().ready <= now) {
      const bool same = from.front().queue == written && has_slot(written, now);
      if (room == 0 || (same && beside == 0)) {
        holds_bus_ = holds_bus_ || turn_ == static_cast<std::uint32_t>(From::kBus);
        others_ = now + 1;
        return;
      }
      if (written == kNone || same) {
        written = from.front().queue;
        --beside;
      }
      --room;
      const std::uint64_t before = waiting_;
      const Coming ray = from.pop();
      write(ray);
      if (waiting_ > before) hold(1, ray.ready);
      if (turn_ == static_cast<std::uint32_t>(From::kBus)) {
        taken_from_bus_ = now;
        holds_bus_ = false;
      }
    }
    turn_ = (turn_ + 1) % 3;
  }
  others_ = kNoCycle;
  for (const auto& from : from_) {
    if (!from.empty()) others_ = std::min(others_, from.front().ready);
  }
}

// The sorter's insertions up to now. It made them on the way, but nobody asks before a queue is chosen.
inline void TurnProcessor::take_in(Cycle now) {
  Cycle cycles = now - sorted_;
  sorted_ = now;
  while (cycles > 0 && !modified_.empty()) {
    const std::uint32_t queue = modified_.pop();
    listed_[queue] = 0;
    if (queue == active_ || queues_[queue].empty()) continue;
    most_.set(queue, static_cast<std::uint32_t>(queues_[queue].size()));
    --cycles;
  }
}

// The active queue gives way when it is empty. False if no ray waits.
inline bool TurnProcessor::choose(Cycle now) {
  if (active_ != kNone) {
    if (!queues_[active_].empty()) return true;
    most_.set(active_, 0);
  }
  take_in(now);
  active_ = kNone;
  if (waiting_ == 0 || most_.importance() == 0) return false;
  active_ = most_.queue();
  ++counters_.activations;
  return true;
}

// The shorter way round the ring. Each hop takes its cycles; the first link is one ray's at a time, and when too many wait at
// its entry the pipeline stands.
void TurnProcessor::cross(const Home& home, const Coming& ray, Cycle out) {
  const auto count = static_cast<unsigned>(with_.processors->size());
  const unsigned right = (home.processor + count - number_) % count;
  const bool to_right = right <= count - right;
  const unsigned hops = to_right ? right : count - right;
  Cycle& free = link_free_[to_right ? 0 : 1];
  const Cycle begin = std::max(free, out + 1);
  free = begin + link_cycles_;
  const Cycle at_the_entry = with_.config->link().rays() * link_cycles_;
  if (begin > out + 1 + at_the_entry) computing_ = std::max(computing_, begin - at_the_entry - compute_);
  ++counters_.rays_sent;
  counters_.hops += hops;
  Coming coming = ray;
  coming.ready = begin + hops * link_cycles_ + kOverRing;
  (*with_.processors)[home.processor]->send(to_right ? From::kLeft : From::kRight, coming);
}

// When the packets are there of a sample that could be resampled in cycle `first`: each is written in a cycle of its own,
// and the last is handed on in that cycle.
inline Cycle TurnProcessor::fetch(const TurnRay& ray, const Point& low, Cycle first) {
  const Misses& misses = cache_.check(ray.block, cell(ray.position, low).voxel);
  if (ideal_memory_) return first;
  const std::uint32_t number = with_.partition->home(ray.block).number;
  TurnMemory& memory = *with_.memory;
  for (std::uint32_t i = 0; i < misses.count; ++i) {
    memory.asked = std::max(memory.asked, now_) + 1;
    const rdram::Location at = memory.layout.locate(number, misses.tiles[i]);
    const Cycle there = memory.channel.read(at, memory.asked * ratio_) + rac_latency_ + ratio_ - 1;
    const Cycle arrival = ratio_bits_ >= 0 ? there >> ratio_bits_ : there / ratio_;
    first = std::max(i == 0 ? first : first + 1, arrival);
    taken_[packets_++ % kRemembered] = first;
  }
  return first;
}

// Out of the pipeline, in cycle `out`.
inline void TurnProcessor::leave(const TurnRay& ray, std::uint32_t queue, Cycle out) {
  if (ray.left <= 0) {
    with_.up->push({ray, out + kToDsp, 0, false, false});
    released_.push({out + 1, queue});
    hold(-1, out);
    return;
  }
  Coming coming{ray, out + kToQueue, 0, false, false};
  coming.ray.block = static_cast<std::uint32_t>(grid_.block(ray.position));
  const Home& home = with_.partition->home(coming.ray.block);
  coming.queue = home.number;
  if (home.processor == number_) {
    coming.keeps_slot = home.number == queue;
    returned_.push(coming);
  } else {
    cross(home, coming, out);
    hold(-1, out);
  }
  if (!coming.keeps_slot) released_.push({out + 1, queue});
}

// One turn of `ray`, which has left `queue`; sets now_ to the cycle in which it enters the pipeline.
inline void TurnProcessor::turn(std::uint32_t queue, TurnRay ray) {
  // The prefetch line is as long as it is, and has room for the packets of a sample.
  if (turns_ >= prefetch_) now_ = std::max(now_, started_[(turns_ - prefetch_) % kRemembered] + 1);
  if (packets_ > room_) now_ = std::max(now_, taken_[(packets_ - room_ - 1) % kRemembered] + 1);

  const Point low = grid_.low(ray.position);
  Cycle begin = std::max(computing_ + 1, now_ + prefetch_);
  std::int32_t steps = 1;
  if (frame_->leap && frame_->empty[ray.block] != 0) {
    ++counters_.leaps;
    steps = std::min(leap_steps(ray.position, ray.step, low, grid_.size()), ray.left);
  } else {
    ++counters_.samples;
    begin = fetch(ray, low, begin);
  }
  computing_ = begin;
  started_[turns_++ % kRemembered] = begin;
  for (std::size_t axis = 0; axis < 3; ++axis) ray.position[axis] += steps * ray.step[axis];
  ray.left -= steps;
  leave(ray, queue, begin + compute_);
}

void TurnProcessor::work(Cycle until, bool bus_waits) {
  const std::size_t on_the_bus = from_bus();
  Cycle now = next(), before = now - 1;
  while (now <= until) {
    std::uint32_t written = kNone;
    Cycle returned = 0;
    for (; !returned_.empty() && returned_.front().ready <= now; ++returned) {
      written = returned_.front().queue;
      write(returned_.pop());
    }
    if (others_ <= now) take_others(now, std::max(now - before, returned), returned, written);
    before = now;
    if (choose(now)) {
      now_ = now;
      --waiting_;
      turn(active_, queues_[active_].pop());
      now = now_ + 1;
    } else {
      now = waiting_ > 0 ? now + 1 : next();
    }
    if (bus_waits && from_bus() < on_the_bus) return;
  }
}

}  // namespace gicube::emu

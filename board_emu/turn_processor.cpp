#include "turn_processor.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace gicube::emu {

namespace {

constexpr std::uint32_t kMostPackets = 8;  // of one neighbourhood
constexpr Cycle kToQueue = 3;              // from the end of the pipeline by the sorter to its beginning
constexpr Cycle kSorter = 2;               // from being written to the pipeline
constexpr Cycle kOverRing = 3;             // from a link by the sorter to the pipeline
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
      to_dsp_(std::bit_width(2 * with_.config->asic().processors() - 1) + 1u),
      tree_places_(2 * static_cast<std::uint32_t>(to_dsp_)),
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
  jitter_ = frame.jitter;
  empty_ = frame.leap ? frame.empty.data() : nullptr;
  grid_ = BlockGrid(*frame.volume);
  block_shift_ = std::countr_zero(static_cast<std::uint32_t>(grid_.size()));
  across_ = static_cast<std::uint32_t>(frame.volume->blocks()[0]);
  slice_ = across_ * static_cast<std::uint32_t>(frame.volume->blocks()[1]);
}

Cycle TurnProcessor::next() const {
  if (stands_) return kNoCycle;
  if (waiting_ > 0) return now_ + 1;
  const Cycle first = std::min(returned_.empty() ? kNoCycle : returned_.front().ready, others_);
  return first == kNoCycle ? first : std::max(first, now_ + 1);
}

// What stood goes on when the place that is free has come down the tree.
void TurnProcessor::taken_from_tree(Cycle now) {
  --in_tree_;
  if (!std::exchange(stands_, false)) return;
  tree_free_ = now + to_dsp_;
}

// For a ray at its last step. Its place may come to be free at a time that is not known yet.
bool TurnProcessor::finds_place() {
  stands_ = in_tree_ >= tree_places_;
  if (!stands_ && tree_free_ > compute_) computing_ = std::max(computing_, tree_free_ - compute_);
  return !stands_;
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
      ++in_tree_;
      with_.up->push({ray.ready - kSorter + to_dsp_, ray.ray, number_, false, true});
      return;
    }
    ++slots_[ray.queue];
  }
  queues_[ray.queue].push(ray.ray);
  ++waiting_;
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
      const bool slot = has_slot(from.front().queue, now), same = from.front().queue == written && slot;
      if (!slot && in_tree_ >= tree_places_) {
        stands_ = true;
        return;
      }
      if (room == 0 || (same && beside == 0) || (!slot && now < tree_free_)) {
        holds_bus_ = holds_bus_ || turn_ == static_cast<std::uint32_t>(From::kBus);
        others_ = now + 1;
        ++counters_.conflicts;
        return;
      }
      if (written == kNone || same) {
        written = from.front().queue;
        --beside;
      }
      --room;
      const std::uint64_t before = waiting_;
      const Coming& ray = from.front();
      write(ray);
      if (waiting_ > before) hold(1, ray.ready);
      from.drop();
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
void TurnProcessor::cross(const Home& home, Coming& ray, Cycle out) {
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
  ray.ready = begin + hops * link_cycles_ + kOverRing;
  (*with_.processors)[home.processor]->send(to_right ? From::kLeft : From::kRight, ray);
}

// When the packets are there of a sample that could be resampled in cycle `first`: each is written in a cycle of its own,
// and the last is handed on in that cycle.
Cycle TurnProcessor::fetch(const TurnRay& ray, Cycle first) {
  const Misses& misses = cache_.check(ray.block, cell(ray.position, Point{}).voxel);
  if (ideal_memory_) return first;
  const std::uint32_t number = with_.partition->home(ray.block).number;
  TurnMemory& memory = *with_.memory;
  for (std::uint32_t i = 0; i < misses.count; ++i) {
    memory.asked = std::max(memory.asked, now_) + 1;
    const rdram::Location at = memory.layout->locate(number, misses.tiles[i]);
    const Cycle there = memory.channel.read(at, memory.asked * ratio_).data_end + rac_latency_ + ratio_ - 1;
    const Cycle arrival = ratio_bits_ >= 0 ? there >> ratio_bits_ : there / ratio_;
    first = std::max(i == 0 ? first : first + 1, arrival);
    taken_[packets_++ % kRemembered] = first;
  }
  return first;
}

// Out of the pipeline for good, or to another processor, in cycle `out`.
void TurnProcessor::leave(std::uint32_t handle, std::uint32_t queue, Cycle out) {
  const TurnRay& ray = (*with_.rays)[handle];
  released_.push({out + 1 + kSorter, queue});
  hold(-1, out);
  if (ray.left <= 0) {
    with_.up->push({out + to_dsp_, handle, number_, false, false});
    ++in_tree_;
    return;
  }
  const Home& home = with_.partition->home(ray.block);
  Coming coming{0, handle, home.number, false, false};
  cross(home, coming, out);
}

Point TurnProcessor::drawn_step(const TurnRay& ray) const {
  const auto words = std::bit_cast<std::array<std::uint16_t, 6>>(ray.step);
  const std::array<std::int16_t, 3> direction{static_cast<std::int16_t>(words[0]), static_cast<std::int16_t>(words[1]),
                                              static_cast<std::int16_t>(words[2])};
  Point position = ray.position;
  const auto corner = grid_.corner(ray.block);
  for (std::size_t axis = 0; axis < 3; ++axis) position[axis] += corner[axis] << wire::kPositionFractionBits;
  const std::uint32_t factor = jitter(position, words[3], words[4]);
  return step_vector(direction, static_cast<std::uint32_t>(round_shift<16>(std::int64_t{frame_->step} * factor)));
}

std::int32_t TurnProcessor::leap(const TurnRay& ray, const Point& step) {
  ++counters_.leaps;
  return std::min(leap_steps(ray.position, step, Point{}, grid_.size()), ray.left);
}

// The ray of `queue` has come into another block.
void TurnProcessor::change_block(std::uint32_t handle, std::uint32_t queue, Cycle out) {
  TurnRay& ray = (*with_.rays)[handle];
  const auto blocks = [&](std::size_t axis) { return static_cast<std::uint32_t>(ray.position[axis] >> block_shift_); };
  ray.block += blocks(0) + across_ * blocks(1) + slice_ * blocks(2);
  for (std::int32_t& at : ray.position) at &= grid_.size() - 1;
  const Home& home = with_.partition->home(ray.block);
  if (home.processor != number_) return leave(handle, queue, out);
  const bool keeps_slot = home.number == queue;
  returned_.push({out + kToQueue, handle, home.number, keeps_slot, false});
  if (!keeps_slot) released_.push({out + 1 + kSorter, queue});
}

// One turn of the ray at the head of `queue`; sets now_ to the cycle in which it enters the pipeline.
inline void TurnProcessor::turn(std::uint32_t queue) {
  LongQueue<std::uint32_t>& from = queues_[queue];
  TurnRays& rays = *with_.rays;
  const std::uint32_t handle = from.front();
  TurnRay& ray = rays[handle];
  from.drop();
  // The prefetch line is as long as it is, and has room for the packets of a sample. Zeroes stand for what was not.
  now_ = std::max({now_, started_[(turns_ - prefetch_) % kRemembered], oldest_taken()});
  Cycle begin = std::max(computing_ + 1, now_ + prefetch_);

  const Point step = jitter_ ? drawn_step(ray) : ray.step;
  std::int32_t x = step[0], y = step[1], z = step[2], steps = 1;
  if (empty_ != nullptr && empty_[ray.block] != 0) {
    steps = leap(ray, step);
    x *= steps, y *= steps, z *= steps;
  } else {
    begin = fetch(ray, begin);
  }
  computing_ = begin;
  started_[turns_++ % kRemembered] = begin;

  ray.position[0] = x += ray.position[0];
  ray.position[1] = y += ray.position[1];
  ray.position[2] = z += ray.position[2];
  ray.left -= steps;
  const Cycle out = begin + compute_;
  if (ray.left <= 0) return leave(handle, queue, out);
  if ((x | y | z) >> block_shift_ != 0) return change_block(handle, queue, out);
  returned_.push({out + kToQueue, handle, queue, true, false});
}

// Turns of the active queue in which a ray takes a step within the block and comes back: most turns are such. The same as turn() and what is round it in work(), as far as that goes.
inline void TurnProcessor::glide(Cycle& now, Cycle& before, Cycle until) {
  const std::uint32_t* const tags = cache_.plain_tags();
  const std::uint32_t queue = active_;
  LongQueue<std::uint32_t>& from = queues_[queue];
  if (from.empty() || tags == nullptr || jitter_) return;
  TurnRays& rays = *with_.rays;
  const std::uint32_t block = rays[from.front()].block;  // of all in the queue
  if (empty_ != nullptr && empty_[block] != 0) return;
  const std::uint64_t both = block * 0x1'0000'0001u, first_only = ~0u;
  const std::size_t tiles_x = cache_.tiles_x(), slice = tiles_x * tiles_x;
  const int shift = block_shift_;
  Cycle taken = oldest_taken();
  std::uint64_t turns = turns_;
  Cycle computing = computing_;
  std::int64_t waiting = 0;
  while (now <= until && now < others_) {
    for (; !returned_.empty() && returned_.front().ready <= now; returned_.drop(), ++waiting) {
      const Coming& back = returned_.front();
      if (back.queue != queue || !back.keeps_slot) break;
      from.push(back.ray);
    }
    if (from.empty() || (!returned_.empty() && returned_.front().ready <= now)) break;
    const std::uint32_t handle = from.front();
    TurnRay& ray = rays[handle];
    const auto voxel = [&ray](std::size_t axis) {
      return static_cast<std::uint32_t>(ray.position[axis]) >> wire::kPositionFractionBits;
    };
    const std::size_t two_x = voxel(0) & 1, row = (voxel(1) & 1) * tiles_x;
    const std::uint32_t* const tile = tags + (voxel(2) * tiles_x + (voxel(1) >> 1)) * tiles_x + (voxel(0) >> 1);
    const auto differs = [both](const std::uint32_t* at) {
      std::uint64_t pair = 0;
      std::memcpy(&pair, at, sizeof pair);
      return pair ^ both;
    };
    const std::uint64_t any = differs(tile) | differs(tile + row) | differs(tile + slice) | differs(tile + slice + row);
    const std::int32_t x = ray.position[0] + ray.step[0], y = ray.position[1] + ray.step[1],
                       z = ray.position[2] + ray.step[2];
    if (ray.left == 1 || (x | y | z) >> shift != 0) break;
    from.drop();
    before = now;
    now_ = now = std::max({now, started_[(turns - prefetch_) % kRemembered], taken});
    computing = std::max(computing + 1, now + prefetch_);
    if ((any & (first_only | -static_cast<std::uint64_t>(two_x))) != 0) {
      computing = fetch(ray, computing);
      taken = oldest_taken();
    }
    started_[turns++ % kRemembered] = computing;
    ray.position = {x, y, z};
    --ray.left;
    returned_.push({computing + compute_ + kToQueue, handle, queue, true, false});
    --waiting;
    ++now;
  }
  turns_ = turns;
  computing_ = computing;
  waiting_ += static_cast<std::uint64_t>(waiting);
}

void TurnProcessor::work(Cycle until, bool bus_waits) {
  const std::size_t on_the_bus = from_bus();
  Cycle now = next(), before = now - 1;
  while (true) {
    if (active_ != kNone) glide(now, before, until);
    if (now > until) return;
    std::uint32_t written = kNone;
    Cycle returned = 0;
    for (; !returned_.empty() && returned_.front().ready <= now; ++returned) {
      const Coming& ray = returned_.front();
      written = ray.queue;
      if (ray.keeps_slot && ray.queue == active_) {  // what most do
        queues_[active_].push(ray.ray);
        ++waiting_;
      } else {
        const std::uint64_t before_it = waiting_;
        write(ray);
        if (waiting_ == before_it) hold(-1, ray.ready);  // it overflowed
      }
      returned_.drop();
    }
    if (others_ <= now) take_others(now, std::max(now - before, returned), returned, written);
    if (stands_) return;
    before = now;
    if (choose(now)) {
      if (in_tree_ + 1 > tree_places_ / 2 && (*with_.rays)[queues_[active_].front()].left == 1 && !finds_place())
        return;
      now_ = now;
      --waiting_;
      turn(active_);
      now = now_ + 1;
    } else {
      now = waiting_ > 0 ? now + 1 : next();
    }
    if (bus_waits && from_bus() < on_the_bus) return;
  }
}

}  // namespace gicube::emu

// The pipeline of frames whose rays do more than gather, event by event: passes enter, have their packets written and begin to be
// resampled, and come out, each when all that could keep it from that is known. The rules are those of cycle/processor.cpp.
#include <algorithm>
#include <utility>

#include "pass_processor.h"

namespace gicube::emu {

// When the first that the sorter has issued enters, if there is room for it and its packets.
inline Cycle PassProcessor::next_entry() const {
  if (issued_.empty() || line_is_full()) return kNoCycle;
  return std::max({issued_.front().ray.ready, entered_ + 1, room_since_});
}

// The next cycle in which the first of those that prefetch takes a packet, or goes on to be resampled.
inline Cycle PassProcessor::next_slot() const {
  const OnLine& first = line_[computing_from_];
  const Cycle slot = std::max({computing_ + 1, free_to_compute_, first.due});
  if (first.packets == 0) return slot;
  return two_ports_ || arrivals_.empty() ? kNoCycle : std::max(slot, arrivals_.front());
}

// Which of those that prefetch waits for the next packet that arrives.
std::size_t PassProcessor::owner_of_next_packet() const {
  std::size_t owner = computing_from_;
  while (line_[owner].packets == 0) ++owner;
  return owner;
}

// The next cycle in which a port of its own writes a packet, unless an older sample of another block has yet to read: then it is not
// known yet.
inline Cycle PassProcessor::next_fill() const {
  if (!two_ports_ || arrivals_.empty()) return kNoCycle;
  const std::size_t owner = owner_of_next_packet();
  for (std::size_t i = computing_from_; i != owner; ++i) {
    if (line_[i].sampled && line_[i].block != line_[owner].block) return kNoCycle;
  }
  const Cycle next = std::max(arrivals_.front(), fill_free_);
  return next == free_to_compute_ ? next + 1 : next;  // then the port writes a splat's words
}

inline PassProcessor::LineEvents PassProcessor::line_events() const {
  const bool stands = line_stands();
  return {.out = !stands && computing_from_ != line_.begin() ? line_.front().due + stood_ : kNoCycle,
          .slot = !stands && computing_from_ != line_.end() ? next_slot() : kNoCycle,
          .entry = next_entry(),
          .write = next_fill()};
}

Cycle PassProcessor::next_in_line() const { return line_events().first(); }

void PassProcessor::fill(Cycle now) {
  arrivals_.drop();
  fill_free_ = now + 1;
  const std::size_t owner = owner_of_next_packet();
  --line_[owner].packets;
  line_[owner].due = std::max(line_[owner].due, now);
}

// All that happens there up to cycle `until`, cycle by cycle; in one cycle a packet is written first, and what comes out goes before
// what goes in. Returns the cycle of the next event after that, kNoCycle if it is not known yet.
Cycle PassProcessor::run_line(Cycle until) {
  while (true) {
    const auto [out, slot, entry, write] = line_events();
    const Cycle now = std::min({out, slot, entry, write});
    if (now > until) return now;
    if (write == now) {
      fill(now);
      continue;
    }
    if (out == now) {
      come_out(now);
      if (two_ports_) continue;  // which may write a packet before
    }
    if (slot == now && !line_stands() && next_slot() == now) {  // what came out may have changed that
      take_slot_of_line(now);
      if (two_ports_) continue;
    }
    if (next_entry() == now) {
      enter(issued_.front(), now);
      issued_.drop();
    }
  }
}

void PassProcessor::take_slot_of_line(Cycle slot) {
  if (line_is_full()) room_since_ = slot;
  computing_ = slot;
  OnLine& first = line_[computing_from_];
  if (first.packets > 0) {
    arrivals_.drop();
    if (--first.packets > 0) return;
  }
  first.due = slot - stood_ + compute_;
  const bool waited = two_ports_ && next_fill() == kNoCycle;
  ++computing_from_;
  if (waited) fill_free_ = std::max(fill_free_, slot + 1);
}

// The line's first comes out in cycle `out`, unless there is no place for it: then the line stands until there is.
void PassProcessor::come_out(Cycle out) {
  OnLine& next = line_[line_.begin()];  // also when it has left, until another enters
  const Cycle due = out;
  if (next.ray.left <= 0 && goes_to_dsp(next.ray.ray)) {
    stalled_ = in_tree_ >= tree_places_;
    if (in_tree_ + 1 > tree_places_ / 2) out = std::max(out, tree_free_);
  } else if (next.leaves) {
    link_stalled_ = out_.size() >= kLeaving;
    out = std::max(out, link_free_);
  }
  if (line_stands()) return;
  line_.drop();
  if (leaves_sums_) {
    const std::int32_t amount = (*shared_.rays)[next.ray.ray].amount;
    if (amount != 0) out = splat(amount_at(unpacked(next.ray.at), next.block, amount), next, true, out);
  }
  const bool goes_on = next.ray.left > 0 || (*shared_.rays)[next.ray.ray].route == nullptr || meets_event(next, out);
  stood_ += out - due;
  if (out > due) free_to_compute_ = std::max(free_to_compute_, out);
  last_out_ = out;
  if (!goes_on) return;
  if (next.ray.left <= 0) {
    finish(next.ray.ray, next.queue, out);
  } else if (next.goes_out) {
    change_block(next.ray, next.queue, next.block, next.to, out);
  } else {
    next.ray.at = next.next;
    next.ray.ready = out + kPipelineToPipeline;
    if (next.queue == active_) {
      active_rays_.push(next.ray);
    } else {
      comes_back({next.ray, next.queue, true});
    }
  }
}

// One ray enters in cycle `now`: its tags are checked, and it is known where it goes. Mostly it takes a step within its block, and its
// words are not looked at.
void PassProcessor::enter(const Issued& issued, Cycle now) {
  const QueuedRay& ray = issued.ray;
  __builtin_prefetch(&(*shared_.rays)[ray.ray]);  // for when it comes out
  entered_ = now;
  if (line_.empty() && now > last_out_) writes_.ask(last_out_ + 1, true);
  ++passes_;
  OnLine& pass = line_.add();
  pass.ray = ray;
  pass.due = now + prefetch_;
  pass.queue = issued.queue;
  pass.block = issued.block;
  pass.packets = 0;
  pass.goes_out = pass.leaves = false;
  pass.sampled = !leaps_over(ray, issued.block);
  std::int32_t steps = 1;
  if (!pass.sampled) {
    ++counters_.leaps;
    steps = 0;
  } else {
    pass.packets = check(cache_, issued, now, false);
    if (frame_->lit_by_irradiance && packs_irradiance()) pass.packets += check(*cells_, issued, now, true);
  }
  pass.next = ray.at + ray.step;
  if (steps == 0 || !packs_steps_ || (pass.next & outside_) != 0) {
    PassRay& of_ray = (*shared_.rays)[ray.ray];
    pass.to = unpacked(ray.at);
    const FinePoint from = fine(pass.to, of_ray.rest);
    const std::int64_t edge = grid_.size();
    const Point corner = jitter_ ? corner_of(issued.block) : Point{};
    if (wide_) {
      const FinePoint step = fine_step_of(ray, corner);
      if (steps == 0) steps = std::min(leap_steps(from, step, FinePoint{}, edge << kRestBits), ray.left);
      const FinePoint to = moved(from, step, steps);
      pass.to = units_of(to);
      of_ray.rest = rest_of(to);
    } else {
      const Point step = step_of(ray, corner);
      if (steps == 0) steps = std::min(leap_steps(pass.to, step, Point{}, grid_.size()), ray.left);
      for (std::size_t axis = 0; axis < 3; ++axis) pass.to[axis] += steps * step[axis];
    }
    pass.goes_out = (pass.to[0] | pass.to[1] | pass.to[2]) >> block_shift_ != 0;
    if (!pass.goes_out) pass.next = packed(pass.to);
  }
  pass.ray.left -= steps;
  if (pass.goes_out && pass.ray.left > 0)
    pass.leaves = shared_.partition->home(block_at(issued.block, pass.to)).processor != number_;
}

bool PassProcessor::leaps_over(const QueuedRay& ray, std::uint32_t block) const {
  if (empty_ == nullptr || empty_[block] == 0) return false;
  const PassRoute* const route = (*shared_.rays)[ray.ray].route.get();
  return route == nullptr || !route->carrier;
}

// Asks for what a sample misses of its voxels, or of their irradiance in packets of its own; returns how many packets that is.
std::uint32_t PassProcessor::check(VolumeCache& cache, const Issued& issued, Cycle now, bool irradiance) {
  const Misses& misses = cache.check(issued.block, cell(unpacked(issued.ray.at), Point{}).voxel);
  if (misses.count == 0) return 0;
  if (writes_back_) {
    for (const TileOfBlock& changed : cache.victims()) write_back(changed, irradiance);
    changed_ = std::max(changed_, now);
  }
  return ask(misses, irradiance ? irradiance_of(issued.queue) : issued.queue, now);
}

// Asks for the packets of a sample; returns how many they are.
std::uint32_t PassProcessor::ask(const Misses& misses, std::uint32_t queue, Cycle now) {
  if (ideal_memory_) return 0;
  send_writes(now);
  PassMemory& memory = *shared_.memory;
  for (std::uint32_t i = 0; i < misses.count; ++i) {
    if (memory.shared()) {
      reads_.push({now, queue, misses.tiles[i]});
      continue;
    }
    memory.asked = std::max(memory.asked, now) + 1;
    arrivals_.push(
        arrival(memory.channel->read(in_memory(queue), misses.tiles[i], to_memory_.from(memory.asked)).data_end));
  }
  return misses.count;
}

void PassProcessor::send_request(Cycle now) {
  if (reads_.empty() || (!writes_.all_sent() && writes_.next().asked < reads_.front().asked)) return send_write(now);
  const PacketRead read = reads_.pop();
  arrivals_.push(
      arrival(shared_.memory->channel->read(in_memory(read.queue), read.tile, to_memory_.from(now)).data_end));
}

// As rotate(), of these frames.
void PassProcessor::rotate_line(Cycle& ends, Cycle until) {
  Cycle next = 0;  // of the line's events
  while (ends <= until) {
    if (next <= ends) next = run_line(ends);
    if (active_rays_.empty() || active_rays_.front().ready > ends) return;
    if (ends > std::min({until, others_ - 1, own_return() - 1})) return;
    before_ = ends;
    if (issued_.size() >= kFifoPlaces) {
      if (next == kNoCycle) return;
      const Cycle first = next;
      if (next <= until) next = run_line(next);
      ends = std::max(ends, issued_.size() < kFifoPlaces ? entered_ + 2 : first);
      now_ = ends - 1;
      continue;
    }
    issued_.push({active_rays_.pop(), active_, block_});
    issued_[issued_.end() - 1].ray.ready = now_ = ends++;
    next = std::min(next, next_entry());
  }
}

}  // namespace gicube::emu

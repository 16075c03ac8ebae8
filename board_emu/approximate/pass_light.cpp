// A processor's part in global illumination, pass by pass: splats, what they keep from entering the pipeline or
// leaving it, and carriers. The rules are those of cycle/splat_unit.h and cycle/processor_light.cpp.
#include <algorithm>
#include <memory>
#include <utility>

#include "asic/cache/splat_tiles.h"
#include "datapath/interaction.h"
#include "memory/irradiance_memory.h"
#include "memory/sum_memory.h"
#include "pass_processor.h"

namespace gicube::emu {

namespace {

constexpr Cycle kSplatCycles = 2;  // in which the cache's one port reads and writes its words

}  // namespace

// The first cycle from `first` on in which a sample may begin to be resampled.
Cycle PassProcessor::enters(Cycle first) {
  while (!held_up_.empty() && held_up_.front().begin + held_up_.front().cycles <= computing_) held_up_.drop();
  for (std::size_t i = held_up_.begin(); i != held_up_.end() && held_up_[i].begin <= first; ++i) {
    first = std::max(first, held_up_[i].begin + held_up_[i].cycles);
  }
  return first;
}

// When what began to be resampled in cycle `computing` comes out.
Cycle PassProcessor::comes_out(Cycle computing) const {
  Cycle out = computing + compute_;
  for (std::size_t i = held_up_.begin(); i != held_up_.end() && held_up_[i].begin <= out; ++i) {
    if (held_up_[i].stalls && held_up_[i].begin > computing) out += held_up_[i].cycles;
  }
  return out;
}

// Before which cycle nothing that enters is held up, nor stalls on its way.
Cycle PassProcessor::undisturbed() const {
  if (held_up_.empty()) return kNoCycle;
  Cycle until = held_up_.front().begin;
  for (std::size_t i = held_up_.begin(); i != held_up_.end(); ++i) {
    if (held_up_[i].stalls) return std::min(until, held_up_[i].begin - std::min<Cycle>(held_up_[i].begin, compute_));
  }
  return until;
}

// Writes of which the memory has been asked before cycle `now`.
void PassProcessor::send_writes(Cycle now) {
  PassMemory& memory = *shared_.memory;
  writes_.send_before(now, [&](const TileWrite& write) {
    memory.asked = std::max(memory.asked, write.asked) + 1;
    memory.channel->write(write.block, write.tile, memory.asked * ratio_);
  });
}

// Tiles that have changed before cycle `now`, in which others may take their places.
void PassProcessor::fetch_lost(Cycle now) {
  PassMemory& memory = *shared_.memory;
  const auto holds = [&](const TileWrite& write) {
    return ideal_memory_ ||
           cache_.holds(static_cast<std::uint32_t>(shared_.partition->block(number_, write.block)), write.tile);
  };
  writes_.lost_before(now, holds, [&](const TileWrite& write) {
    memory.asked = std::max(memory.asked, write.asked) + 1;
    memory.channel->read(write.block, write.tile, memory.asked * ratio_);
  });
}

Cycle PassProcessor::finish_writes() {
  fetch_lost(kNoCycle);
  if (writes_.empty()) return 0;
  writes_.ask(std::max(computing_ + compute_, writes_.changed()) + 1);
  send_writes(kNoCycle);
  return shared_.memory->asked + 1;
}

// Of a ray that backprojects, at a place from the active block's corner.
Deposit PassProcessor::amount_at(Point place, std::int32_t amount) const {
  for (std::size_t axis = 0; axis < 3; ++axis) place[axis] += corner_[axis];
  Deposit deposit = spread_at(place, amount);
  if (writes_all_voxels_) deposit.shares.fill(1);
  return deposit;
}

// Mostly it is the active one alone, as is seen at once.
SharingBlocks PassProcessor::blocks_of(const Deposit& deposit) const {
  const std::int32_t n = grid_.size() >> wire::kPositionFractionBits, first = leaves_sums_ ? 0 : 1;
  bool inside = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t local = deposit.voxel[axis] - (corner_[axis] >> wire::kPositionFractionBits);
    inside = inside && local >= first && local + 1 < n;
  }
  if (inside) return {1, {block_}};
  return leaves_sums_ ? frame_->sums->blocks_of(deposit) : frame_->irradiance->blocks_of(deposit);
}

// The deposit of a ray of the active queue, whose carriers go to other blocks unless it is one itself. The ray comes out of the
// pipeline in cycle `out`, or later if it must wait: returns when.
Cycle PassProcessor::splat(const Deposit& deposit, bool carries, Cycle out) {
  const SharingBlocks sharing = blocks_of(deposit);
  const Cycle begin = writes_.room_from(std::max(out, splat_free_));
  if (begin > out) held_up_.push({out, begin - out, true});
  const auto edge = static_cast<std::int32_t>(grid_.size() >> wire::kPositionFractionBits) + 1;
  Cycle carriers = 0;
  bool here = false;
  for (std::size_t i = 0; i < sharing.count; ++i) {
    if (sharing.block[i] == block_) {
      here = true;
    } else if (carries) {
      carry(deposit, sharing.block[i], begin + ++carriers);
    }
  }
  counters_.carriers += carriers;
  const SplatTiles tiles =
      here ? tiles_of(deposit, {grid_.corner(block_), edge, edge - (leaves_sums_ ? 2 : 1)}, false) : SplatTiles();
  for (std::uint32_t i = 0; i < tiles.count; ++i) {
    writes_.put(active_, tiles.tile[i], combines_, begin);
  }
  splat_free_ = begin + carriers;
  if (tiles.count > 0) {
    ++counters_.deposits;
    held_up_.push({begin, kSplatCycles, false});
    splat_free_ = std::max(splat_free_, begin + kSplatCycles);
  }
  return begin;
}

// A ray that takes the deposit to another block leaves in cycle `when`.
void PassProcessor::carry(const Deposit& deposit, std::uint32_t block, Cycle when) {
  const std::array<std::int32_t, 3> corner = grid_.corner(block);
  const std::int32_t most = (grid_.size() >> wire::kPositionFractionBits) - 1;
  PassRay ray;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.position[axis] = std::clamp(deposit.voxel[axis] - corner[axis], 0, most) << wire::kPositionFractionBits;
  }
  ray.left = 1;
  ray.block = block;
  ray.route = std::make_unique<PassRoute>();
  ray.route->carrier = true;
  ray.route->events.push_back({.steps = 1, .deposits = true, .ends = true, .deposit = deposit});
  const std::uint32_t handle = shared_.rays->add(std::move(ray));
  const Home& home = shared_.partition->home(block);
  if (home.processor == number_) {
    hold(1, when);
    comes_back({queued_ray(handle, when + kPipelineToPipeline), home.number, false});
    return;
  }
  ++counters_.rays_sent;
  out_.push({when + 1, home.processor, {0, handle, home.number}});
  if (!out_blocked_) enter_links();
}

// The first ray's event, which it has come to: where it goes on from its block's corner, or that it does not.
bool PassProcessor::meets_event(QueuedRay& ray, Point& at, Cycle& out) {
  PassRoute& route = *(*shared_.rays)[ray.ray].route;
  const TrailEvent& event = route.events[route.next];
  if (event.deposits) out = splat(event.deposit, !route.carrier, out);
  if (route.carrier) {
    release(active_, out);
    hold(-1, out);
    shared_.rays->remove(ray.ray);
    ++counters_.carried;
    return false;
  }
  if (event.ends || event.trapped) {
    finish(ray.ray, out);
    return false;
  }
  ray.left = route.events[++route.next].steps;
  if (!event.turns) return true;
  PassRay& of_ray = (*shared_.rays)[ray.ray];
  of_ray.follow(event.way, jitter_);
  ray.step = packed(field_step(of_ray.step));
  for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = of_ray.position[axis] - corner_[axis];
  return true;
}

}  // namespace gicube::emu

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

constexpr std::size_t kSplatPlaces = 16;  // eight tiles, each fetched first

}  // namespace

void PassProcessor::send_write(Cycle now) {
  const TileWrite& write = writes_.next();
  if (write.fetch) {
    shared_.memory->channel->read(in_memory(write.block), write.tile, to_memory_.from(now));
  } else {
    shared_.memory->channel->write(in_memory(write.block), write.tile, to_memory_.from(now));
  }
  writes_.send(now);
}

// Writes of which the memory has been asked before cycle `now`.
void PassProcessor::send_writes(Cycle now) {
  if (changed_ + 1 < now) writes_.ask(changed_ + 1, false);
  PassMemory& memory = *shared_.memory;
  if (memory.shared()) return;
  while (!writes_.all_sent() && writes_.next().asked < now) {
    memory.asked = std::max(memory.asked, writes_.next().asked) + 1;
    send_write(memory.asked);
  }
}

// The first cycle from `now` on in which a splat finds its places. A shared memory goes on without what the other may ask for until then.
Cycle PassProcessor::room_from(Cycle now) {
  for (;; ++now) {
    send_writes(now);
    while (shared_.memory->shared() && writes_.room() < kSplatPlaces && shared_.memory->next() <= now)
      shared_.memory->send();
    writes_.settle(now);
    if (writes_.room() >= kSplatPlaces) return now;
  }
}

Cycle PassProcessor::finish_writes() {
  if (writes_.empty() && !cache_.has_changes() && !(cells_ && cells_->has_changes())) return 0;
  changed_ = std::max(last_out_, changed_);
  while (cache_.has_changes()) write_back(cache_.clean(), false);
  while (cells_ && cells_->has_changes()) write_back(cells_->clean(), true);
  writes_.ask(changed_ + 1, true);
  send_writes(kNoCycle);
  while (shared_.memory->shared() && shared_.memory->next() != kNoCycle) shared_.memory->send();
  writes_.settle(kNoCycle);
  return shared_.memory->asked + 1;
}

Point PassProcessor::corner_of(std::uint32_t block) const {
  if (block == block_) return corner_;
  Point corner = grid_.corner(block);
  for (std::int32_t& at : corner) at <<= wire::kPositionFractionBits;
  return corner;
}

// Of a ray that backprojects, at a place from the block's corner.
Deposit PassProcessor::amount_at(Point place, std::uint32_t block, std::int32_t amount) const {
  const Point corner = corner_of(block);
  for (std::size_t axis = 0; axis < 3; ++axis) place[axis] += corner[axis];
  Deposit deposit = spread_at(place, amount);
  if (writes_all_voxels_) deposit.shares.fill(1);
  return deposit;
}

// Mostly it is the ray's alone, as is seen at once.
SharingBlocks PassProcessor::blocks_of(const Deposit& deposit, std::uint32_t block) const {
  const Point corner = corner_of(block);
  const std::int32_t n = grid_.size() >> wire::kPositionFractionBits, first = leaves_sums_ ? 0 : 1;
  bool inside = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t local = deposit.voxel[axis] - (corner[axis] >> wire::kPositionFractionBits);
    inside = inside && local >= first && local + 1 < n;
  }
  if (inside) return {1, {block}};
  return leaves_sums_ ? frame_->sums->blocks_of(deposit) : frame_->irradiance->blocks_of(deposit);
}

// The deposit of a pass, whose carriers go to other blocks unless its ray is one itself. It comes out of the pipeline in cycle `out`, or
// later if it must wait: returns when.
Cycle PassProcessor::splat(const Deposit& deposit, const OnLine& from, bool carries, Cycle out) {
  const SharingBlocks sharing = blocks_of(deposit, from.block);
  const Cycle begin = room_from(std::max(out, splat_free_));
  const auto edge = static_cast<std::int32_t>(grid_.size() >> wire::kPositionFractionBits) + 1;
  Cycle carriers = 0;
  bool here = false;
  for (std::size_t i = 0; i < sharing.count; ++i) {
    if (sharing.block[i] == from.block) {
      here = true;
    } else if (carries) {
      carry(deposit, sharing.block[i], begin + ++carriers);
    }
  }
  counters_.carriers += carriers;
  SplatTiles tiles;
  if (here) {
    Point corner = corner_of(from.block);
    for (std::int32_t& at : corner) at >>= wire::kPositionFractionBits;
    tiles = tiles_of(deposit, {corner, edge, edge - (leaves_sums_ ? 2 : 1), packs_irradiance() ? 2 : 1}, false);
  }
  for (std::uint32_t i = 0; i < tiles.count; ++i) {
    change(from, tiles.tile[i]);
  }
  splat_free_ = begin + carriers;
  if (tiles.count > 0) {
    ++counters_.deposits;
    changed_ = begin;
    free_to_compute_ = begin + splat_cycles_;
    splat_free_ = std::max(splat_free_, begin + splat_cycles_);
    if (shared_.memory->shared()) writes_.ask(changed_ + 1, false);
  }
  return begin;
}

// A tile has changed: it is written soon, or when it leaves the cache. Irradiance in packets of its own comes into the cache here.
void PassProcessor::change(const OnLine& from, std::uint32_t tile) {
  const bool packs = packs_irradiance();
  VolumeCache& cache = packs ? *cells_ : cache_;
  const bool known = packs ? cache.touch(from.block, tile) : cache.holds(from.block, tile);
  const std::uint32_t block = packs ? irradiance_of(from.queue) : from.queue;
  if (!writes_back_ || !(known || packs)) return writes_.put(block, tile, ideal_memory_ || known, combines_);
  if (packs) {
    for (const TileOfBlock& changed : cache.victims()) write_back(changed, true);
  }
  if (!known && !ideal_memory_) writes_.fetch(block, tile);
  writes_.change(cache.change(from.block, tile));
}

void PassProcessor::write_back(const TileOfBlock& changed, bool irradiance) {
  const std::uint32_t number = shared_.partition->home(changed.block).number;
  writes_.write_back(irradiance ? irradiance_of(number) : number, changed.tile);
}

// A ray that takes the deposit to another block leaves in cycle `when`.
void PassProcessor::carry(const Deposit& deposit, std::uint32_t block, Cycle when) {
  const std::array<std::int32_t, 3> corner = grid_.corner(block);
  const std::int32_t most = (grid_.size() >> wire::kPositionFractionBits) - 1;
  PassRay ray;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.position[axis] = std::clamp(deposit.voxel[axis] - corner[axis], 0, most) << wire::kPositionFractionBits;
  }
  ray.next_contribution = kFullContribution;
  ray.begin_way(1, kFullContribution);
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

// The event to which a pass has taken its ray: where that goes on, or that it does not.
bool PassProcessor::meets_event(OnLine& pass, Cycle& out) {
  QueuedRay& ray = pass.ray;
  PassRoute& route = *(*shared_.rays)[ray.ray].route;
  const TrailEvent& event = route.events[route.next];
  if (event.deposits) out = splat(event.deposit, pass, !route.carrier, out);
  if (route.carrier) {
    release(pass.queue, out);
    hold(-1, out);
    shared_.rays->remove(ray.ray);
    ++counters_.carried;
    return false;
  }
  if (event.ends || event.trapped) {
    finish(ray.ray, pass.queue, out);
    return false;
  }
  const TrailEvent& next = route.events[++route.next];
  PassRay& of_ray = (*shared_.rays)[ray.ray];
  of_ray.begin_way(next.steps, next.contribution);
  ray.left = next.steps;
  if (!event.turns) return true;
  of_ray.follow(event.way, jitter_);
  ray.step = packed(field_step(of_ray.step));
  const Point corner = corner_of(pass.block);
  for (std::size_t axis = 0; axis < 3; ++axis) pass.to[axis] = of_ray.position[axis] - corner[axis];
  pass.goes_out = (pass.to[0] | pass.to[1] | pass.to[2]) >> block_shift_ != 0;
  if (!pass.goes_out) pass.next = packed(pass.to);
  return true;
}

}  // namespace gicube::emu

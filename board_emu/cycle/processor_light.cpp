// Global illumination in the processor: samples that deposit or scatter, splats and irradiance carriers.
#include <algorithm>

#include "asic/cache/splat_tiles.h"
#include "datapath/bricks.h"
#include "datapath/interaction.h"
#include "processor.h"

namespace gicube::emu {

// Applies the effects of a sample at `position` of a ray that does more than gather: splats, a trap, the ray's end.
// `ray` is still in the block of the sample.
Termination Processor::after(const Interaction& interaction, const Point& position, RayUnderWay& ray, InFlight& entry) {
  if (interaction.deposits) {
    splat_and_carry(interaction, ray, entry);
  } else if (writes_all_voxels() && ray.ray_state.is(wire::kLightingRay) &&
             (interaction.visible || splat_rule_ == v1::all_samples)) {
    Interaction nothing;
    nothing.place = position;
    nothing.lifetime = ray.ray_state.lifetime;
    nothing.deposit = nothing_at(position);
    splat_and_carry(nothing, ray, entry);
  }
  if (interaction.outcome == Outcome::kTrapped) entry.token.state = TokenStatus::kTrapped;
  return interaction.outcome == Outcome::kEnded ? Termination::kAbsorbed : Termination::kActive;
}

// Writes the deposit's voxels in the ray's block, and sends carriers to the other blocks that have copies of them.
void Processor::splat_and_carry(const Interaction& interaction, RayUnderWay& ray, InFlight& entry) {
  const std::uint32_t block = ray.block;
  const Deposit here = on_card(interaction.deposit, *frame_);
  Deposit written = here;
  if (writes_all_voxels()) written.shares.fill(1);
  const SharingBlocks sharing = blocks_of(written, *frame_);
  Splat* work = nullptr;
  for (std::size_t i = 0; i < sharing.count; ++i) {
    if (sharing.block[i] == block) work = &splat(block, interaction, ray.ray_state, entry);
  }
  for (std::size_t i = 0; i < sharing.count; ++i) {
    if (sharing.block[i] == block) continue;
    if (is_irradiance_at_host(sharing.block[i])) {  // its copies are made when it comes to the card
      frame_->irradiance->add(here, sharing.block[i]);
      continue;
    }
    if (work == nullptr) work = &add_splat(block, entry);
    work->carrier[work->carriers++] = carrier(ray.ray_state, interaction, sharing.block[i]);
    if (entry.token.watched) [[unlikely]]
      watch_carrier(entry.token.ray, work->carrier[work->carriers - 1]);
  }
  carry_to_host(interaction, ray, entry, work);
}

// Sends the deposit to the DSP for each block whose irradiance is at the host.
void Processor::carry_to_host(const Interaction& interaction, const RayUnderWay& ray, InFlight& entry, Splat* work) {
  if (frame_->irradiance_at_host.empty()) return;
  SharingBlocks owners;
  for_each_share(interaction.deposit, *frame_->irradiance, [&](std::size_t, std::size_t owner, const auto&) {
    const auto known = std::span(owners.block).first(owners.count);
    if (!is_irradiance_at_host(owner) || std::ranges::find(known, owner) != known.end()) return;
    owners.block[owners.count++] = static_cast<std::uint32_t>(owner);
  });
  for (std::size_t i = 0; i < owners.count; ++i) {
    if (work == nullptr) work = &add_splat(ray.block, entry);
    RayToken& token = work->carrier[work->carriers++];
    token = carrier(ray.ray_state, interaction, owners.block[i]);
    token.state = TokenStatus::kNonResident;
  }
}

void Processor::watch_carrier(std::uint32_t from, RayToken& carrier) {
  carrier.watched = true;
  watch_.made_carrier(from, carrier.ray);
}

Splat& Processor::add_splat(std::uint32_t block, InFlight& entry) {
  Splat& work = splats_.add();
  work.block = block;
  entry.splats = true;
  return work;
}

// Adds the deposit to the words of `block`, and records which of its tiles are written.
Splat& Processor::splat(std::uint32_t block, const Interaction& interaction, const RayState& from, InFlight& entry) {
  const Deposit deposit = on_card(interaction.deposit, *frame_);
  add_to_block(block, deposit, interaction, from, *frame_, counts_);
  Splat& work = add_splat(block, entry);
  const auto edge = static_cast<std::int32_t>(edge_);
  const SplatTiles tiles = tiles_of(
      deposit,
      {grid_.corner(block), edge, edge - (frame_->accumulators != nullptr ? 2 : 1), packs_irradiance() ? 2 : 1},
      writes_all_voxels());
  work.tiles = static_cast<std::uint8_t>(tiles.count);
  work.tile = tiles.tile;
  return work;
}

// Makes a carrier of the deposit for a block that has copies of its voxels [P §3.4].
RayToken Processor::carrier(const RayState& from, const Interaction& interaction, std::uint32_t block) {
  RayUnderWay ray;
  ray.ray_state.position = interaction.place;
  ray.ray_state.u = from.u;
  ray.ray_state.v = from.v;
  ray.ray_state.lifetime = interaction.lifetime;
  ray.ray_state.flags = wire::kLightingRay | wire::kIrradianceCarrier;
  for (std::size_t word = 0; word < frame_->light_words; ++word) {
    const std::uint64_t units = interaction.units[word];
    ray.ray_state.set_energy(word, frame_->accumulators != nullptr ? units & 0xFF'FFFF : units << kEnergyFractionBits);
  }
  ray.block = block;
  RayToken token;
  token.ray = rays_.add(ray);
  const Home& home = partition_.home(block);
  token.processor = home.processor;
  token.queue = single_queue_ ? 0 : home.number;
  token.contribution = kFullContribution;
  return token;
}

// The cell of a carrier in its block, for which the tags are checked. The position may be a voxel outside the block.
Cell Processor::carrier_cell(const RayUnderWay& ray) const {
  const std::array<std::int32_t, 3> corner = grid_.corner(ray.block);
  Cell out{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t voxel = (ray.ray_state.position[axis] >> wire::kPositionFractionBits) - corner[axis];
    out.voxel[axis] = static_cast<std::uint32_t>(std::clamp(voxel, 0, static_cast<std::int32_t>(edge_) - 2));
  }
  return out;
}

void Processor::write_back(const TileOfBlock& changed, bool irradiance) {
  const std::uint32_t number = partition_.home(changed.block).number;
  writes_.write_back(irradiance ? irradiance_of(number) : number, changed.tile);
}

// Writes back one tile per cycle.
void Processor::write_rest() {
  if (writes_.room() == 0) return;
  if (cache_.has_changes()) {
    write_back(cache_.clean(), false);
  } else if (cells_ && cells_->has_changes()) {
    write_back(cells_->clean(), true);
  }
}

bool Processor::tick_light(Cycle now) {
  writes_.settle(now);
  writes_.ask(now, stages_.empty());
  return splats_.has_carrier() && send_carrier(now);
}

// Sends the splat's next carrier. Returns whether it was sent.
bool Processor::send_carrier(Cycle now) {
  const RayToken& token = splats_.carrier();
  Fifo<RayToken>& to = token.state == TokenStatus::kNonResident ? done
                       : token.processor == number_             ? returned_
                                                                : out_links;
  if (!to.can_push(now)) return false;
  to.push(now, token);
  splats_.sent_carrier();
  return true;
}

// Whether the oldest splat is stalled: the previous one is not finished, or the write queue has no room for its tiles.
bool Processor::splat_waits(Cycle now) const {
  constexpr std::size_t kSlots = 16;  // eight tiles, each fetched first
  return splats_.busy(now) || writes_.room() < kSlots;
}

void Processor::begin_splat(Cycle now) {
  const Splat& work = splats_.oldest();
  for (std::size_t i = 0; i < work.tiles; ++i) write(work.block, work.tile[i], packs_irradiance());
  splats_.begin(now);
}

// Records a changed tile. Irradiance in its own packets is loaded into the cache here, not when its voxels are read.
void Processor::write(std::uint32_t block, std::uint32_t tile, bool irradiance) {
  VolumeCache& cache = irradiance ? *cells_ : cache_;
  const bool known = irradiance ? cache.access(block, tile) : cache.probe(block, tile);
  const std::uint32_t number = partition_.home(block).number, at = irradiance ? irradiance_of(number) : number;
  if (write_policy_ != v1::write_back) {
    writes_.put(at, tile, ideal_memory_ || known, write_policy_ != v1::write_through);
    return;
  }
  if (irradiance) {
    for (const TileOfBlock& changed : cache.evictions()) write_back(changed, true);
  }
  if (known || irradiance) {
    if (!known && !ideal_memory_) writes_.fetch(at, tile);
    writes_.change(cache.change(block, tile));
  } else {
    writes_.put(at, tile, ideal_memory_);
  }
}

}  // namespace gicube::emu

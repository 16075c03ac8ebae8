// Deposits of rays in the irradiance words: their energy, and how it is split among voxels and words.
#include <algorithm>

#include "datapath/interaction.h"
#include "datapath/random_stream.h"
#include "datapath/trilinear_splat.h"
#include "memory/accumulator_memory.h"

namespace gicube::emu {

namespace {

// Sets the deposit's voxel to that of least coordinates around `place`; returns the fractions of `place` in the cell.
std::array<std::uint32_t, 3> put_at(const Point& place, Deposit& out) {
  constexpr std::uint32_t kFractionMask = static_cast<std::uint32_t>(wire::kVoxel) - 1;
  std::array<std::uint32_t, 3> fraction{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.voxel[axis] = place[axis] >> wire::kPositionFractionBits;
    fraction[axis] = static_cast<std::uint32_t>(place[axis]) & kFractionMask;
  }
  return fraction;
}

Deposit split_at(const Point& place, std::uint32_t units, std::uint16_t u, std::uint16_t v, std::uint16_t lifetime,
                 std::uint32_t seed) {
  Deposit out;
  const auto fraction = put_at(place, out);
  out.shares = split(units, fraction, draw_at(RandomStream::kSplat, place, u, v, lifetime, seed));
  return out;
}

// The deposit in all words together, of a ray or of a carrier.
Deposit split_all(const Interaction& interaction, const RayState& ray, const Frame& frame) {
  Deposit all = deposit_in(0, interaction, ray, frame);
  for (std::size_t word = 1; word < frame.light_words; ++word) {
    const Deposit one = deposit_in(word, interaction, ray, frame);
    for (std::size_t i = 0; i < all.shares.size(); ++i) all.shares[i] += one.shares[i];
  }
  return all;
}

}  // namespace

Deposit spread_at(const Point& place, std::int32_t amount) {
  Deposit out;
  const SignedShares shares = spread(amount, put_at(place, out));
  for (std::size_t i = 0; i < shares.size(); ++i) out.shares[i] = static_cast<std::uint32_t>(shares[i]);
  return out;
}

void count_emitted(const RayState& ray, const Frame& frame, RayCounters& counters) {
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    counters.energy_of(word).emitted += energy_units(ray, frame, word);
  }
}

EnergyUnits all_units(const RayState& ray, const Frame& frame) {
  EnergyUnits out{};
  for (std::size_t word = 0; word < frame.light_words; ++word) out[word] = energy_units(ray, frame, word);
  return out;
}

void deposit(Interaction& interaction, const RayState& ray, const EnergyUnits& units, const Point& place,
             const Frame& frame) {
  if (units == EnergyUnits{}) return;
  interaction.deposits = true;
  interaction.place = place;
  interaction.units = units;
  interaction.lifetime = ray.lifetime;
  interaction.deposit = split_all(interaction, ray, frame);
}

Deposit nothing_at(const Point& place) {
  Deposit out;
  put_at(place, out);
  return out;
}

Deposit deposit_in(std::size_t word, const Interaction& interaction, const RayState& ray, const Frame& frame) {
  return split_at(interaction.place, interaction.units[word], ray.u, ray.v, interaction.lifetime, frame.seed);
}

Interaction brought_by(const RayState& carrier, const Frame& frame) {
  Interaction out;
  out.deposits = true;
  out.place = carrier.position;
  out.lifetime = carrier.lifetime;
  if (frame.accumulators != nullptr) {
    out.deposit = spread_at(carrier.position, carrier.amount());
    return out;
  }
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    out.units[word] = static_cast<std::uint32_t>(carrier.energy(word) >> kEnergyFractionBits);
  }
  out.deposit = split_all(out, carrier, frame);
  return out;
}

Interaction backproject(RayState& ray, const Frame& frame, RayCounters& counters) {
  Interaction interaction;
  interaction.visible = true;
  const std::int32_t amount = ray.amount();
  ++counters.deposits;
  if (frame.accumulators != nullptr) {
    interaction.deposits = amount != 0;
    interaction.place = ray.position;
    interaction.units[0] = static_cast<std::uint32_t>(amount);
    interaction.deposit = spread_at(ray.position, amount);
  } else {  // stochastic rounding of fractions, by position
    constexpr int kFraction = wire::kAmountFractionBits;
    const std::uint64_t chance =
        draw_at(RandomStream::kPhase, ray.position, ray.u, ray.v, 0, frame.seed) >> (64 - kFraction);
    deposit(interaction, ray, {(static_cast<std::uint32_t>(amount) + static_cast<std::uint32_t>(chance)) >> kFraction},
            ray.position, frame);
    counters.energy.emitted += interaction.units[0];
  }
  advance(ray, 1, frame);
  return interaction;
}

void expect_deposits(const Frame& frame) {
  if (frame.accumulators != nullptr) frame.accumulators->moved_anywhere(frame.max_moved);
}

SharingBlocks blocks_of(const Deposit& deposit, const Frame& frame) {
  return frame.accumulators != nullptr ? frame.accumulators->blocks_of(deposit) : frame.irradiance->blocks_of(deposit);
}

void add_to_block(std::uint32_t block, const Deposit& deposit, const Interaction& interaction, const RayState& from,
                  const Frame& frame, RayCounters& counters) {
  if (std::ranges::all_of(deposit.shares, [](auto share) { return share == 0; })) return;  // no word changes
  if (frame.accumulators != nullptr) {
    counters.energy.deposited.kept += static_cast<std::uint64_t>(frame.accumulators->add(deposit, block));
  } else if (frame.light_words == 1) {
    counters.energy.deposited += frame.irradiance->add(deposit, block);
  } else {
    for (std::size_t word = 0; word < frame.light_words; ++word) {
      counters.energy_of(word).deposited +=
          frame.irradiance[word].add(deposit_in(word, interaction, from, frame), block);
    }
  }
}

}  // namespace gicube::emu

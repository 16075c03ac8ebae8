// Interaction of a sample with a ray that does more than gather: lighting rays, and rendering rays that are lit by
// irradiance or scattered [P §2.2]. Pure functions of the ray and the volume, for every fidelity level.
//
// A sample represents the step that follows it; with the conserving rules, a lighting ray's sample represents its
// integration interval (ray_interval.h). Absorption and scattering share its opacity a [H903, H904]:
//   low albedo    the ray keeps 1 - (1 - Ks) a of its energy, or of its transparency, and deposits the rest; of the
//                 kept part, the fraction Ks a / (1 - (1 - Ks) a) is scattered
//   high albedo   the ray interacts when the accumulated a reaches its interaction value; it is then scattered with
//                 probability Ks, or absorbed completely
#pragma once

#include <optional>

#include "datapath/random_stream.h"
#include "datapath/ray_step.h"
#include "datapath/scatter.h"
#include "datapath/scattering.h"
#include "gicube/wire/trap.h"

namespace gicube::emu {

struct KnownInterval;

// A resampled and classified sample.
struct Sample {
  Channels channels{};  // density, gradient
  unsigned tag = 0;
  wire::SegmentationEntry entry{};  // with the voxels' colour
  std::size_t index = 0;            // index of `entry`

  Point gradient() const { return point_of(channels); }
};

Sample sample_at(const Point& position, const Frame& frame);

// Whole units of energy, per irradiance word.
using EnergyUnits = std::array<std::uint32_t, kColours>;

enum class Outcome : std::uint8_t { kGoesOn, kEnded, kTrapped };

struct Interaction {
  Outcome outcome = Outcome::kGoesOn;
  bool visible = false;  // the sample has an opacity
  bool deposits = false;
  // If `deposits`: position, not always in the sample's block; energy; and lifetime on this path segment.
  Deposit deposit;  // with three irradiance words: the sum of their shares
  Point place{};
  EnergyUnits units{};  // per word; signed for accumulators
  std::uint16_t lifetime = 0;
};

// A deposit of no energy around `place`.
Deposit nothing_at(const Point& place);

// Deposits `units` in the voxels around `place`, unless all are 0.
void deposit(Interaction& interaction, const RayState& ray, const EnergyUnits& units, const Point& place,
             const Frame& frame);

// Contribution of a backprojecting ray's sample at `place` to the accumulators.
Deposit spread_at(const Point& place, std::int32_t amount);

// The deposit of an irradiance carrier: the energy is split among the voxels around its position as by the ray that
// sent it.
Interaction brought_by(const RayState& carrier, const Frame& frame);

// The deposit of `ray`, or of its carrier, in one of three irradiance words.
Deposit deposit_in(std::size_t word, const Interaction& interaction, const RayState& ray, const Frame& frame);

// Takes a sample, and advances or scatters the ray. `known`: null, or what lanes of rays have computed of the sample.
Interaction interact(RayState& ray, const SampleSite& site, const Frame& frame, RayCounters& counters,
                     const KnownInterval* known = nullptr);

// Starts a new path segment of a scattered ray, along `direction`.
void redirect(RayState& ray, const Direction& direction, const Frame& frame);

// After a skip the ray is no longer at a surface.
inline void leave_surface(RayState& ray) { ray.flags &= static_cast<std::uint8_t>(~wire::kTrapped); }

// Whether rays skip the block.
inline bool is_skipped(std::size_t block, const Frame& frame) { return frame.skip_empty && frame.empty[block] != 0; }

// One iteration of a ray that has not ended is one of the following three functions.

// Skips the ray's empty block with least corner `low` and edge `size`. Returns the number of steps.
inline std::int32_t skip_block(RayState& ray, const Point& low, std::int32_t size, const Frame& frame,
                               RayCounters& counters) {
  jitter_step(ray, frame);
  ++counters.leaps;
  leave_surface(ray);
  ray.under_way = true;
  const std::int32_t steps = skip_steps(ray, low, size, frame);
  advance(ray, steps, frame);
  count_steps(ray, steps, frame);
  return steps;
}

// Gathers a sample, in a plain frame.
inline void gather(RayState& ray, const SampleSite& site, const Frame& frame, RayCounters& counters) {
  jitter_step(ray, frame);
  ++counters.samples;
  if (take_sample(ray, site, frame)) ++counters.visible_samples;
  advance(ray, 1, frame);
  count_steps(ray, 1, frame);
}

// Takes a sample that may also deposit, scatter or end the ray, in any other frame.
inline Interaction sample(RayState& ray, const SampleSite& site, const Frame& frame, RayCounters& counters,
                          const KnownInterval* known = nullptr) {
  jitter_step(ray, frame);
  ++counters.samples;
  const Interaction interaction = interact(ray, site, frame, counters, known);
  if (interaction.visible) ++counters.visible_samples;
  count_steps(ray, 1, frame);
  return interaction;
}

// Applies the host's answer (trap.h) to a ray that waited for it. Returns true if that ends the ray: the packet is then
// in the form of pack(), otherwise ready for unpack(). The energy of the answer counts as emitted.
bool take_answer(wire::Ray& ray, const Frame& frame, RayCounters& counters);

// A request to a routine of the DSP.
struct Trap {
  std::uint8_t routine = 0;
  ScatterEvent event;
};

// The request of a trapped ray. Empty: the host must answer; the ray is in the frame's HostTraps.
std::optional<Trap> trap_of(RayState& ray, const Frame& frame);

// Continues or ends the trapped ray according to the answer. Counts the cycles of the DSP.
Interaction answer_trap(RayState& ray, const ScatterAnswer& answer, const Frame& frame, RayCounters& counters);

// Opacity at which the ray interacts, 24 bits; the packet has 12 of them, the wide datapath all. The printed rules keep
// one value for the whole path [P §2.2], which correlates its segments.
std::uint32_t interaction_value(const RayState& ray, const Frame& frame);

// The value added to an energy before its fraction is cut off: one draw per ray.
inline std::uint32_t energy_phase(const RayState& ray, const Frame& frame) {
  return static_cast<std::uint32_t>(draw(RandomStream::kPhase, ray.u, ray.v, 0, frame.seed) >>
                                    (64 - kEnergyFractionBits));
}
// The whole energy units of the ray for an irradiance word. The fraction is rounded by one draw per ray, so that the
// ray's deposits sum exactly to its energy.
inline std::uint32_t energy_units(const RayState& ray, const Frame& frame, std::size_t word = 0) {
  return static_cast<std::uint32_t>((ray.energy(word) + energy_phase(ray, frame)) >> kEnergyFractionBits);
}
EnergyUnits all_units(const RayState& ray, const Frame& frame);  // per word
// Counts the energy of a ray at its start.
void count_emitted(const RayState& ray, const Frame& frame, RayCounters& counters);

// Counts a ray that has ended, and the energy that leaves with it.
void count_end(const RayState& ray, Termination how, const Frame& frame, RayCounters& counters);

// The sample of a ray that backprojects: each makes the same contribution.
Interaction backproject(RayState& ray, const Frame& frame, RayCounters& counters);
// To be called before the frame's rays if their deposits use add_to_block(): rays that backproject may change any
// accumulator.
void expect_deposits(const Frame& frame);
// The blocks that have words of the deposit's voxels: accumulators of rays that backproject, otherwise irradiance.
SharingBlocks blocks_of(const Deposit& deposit, const Frame& frame);
// Adds the interaction's deposit to the words of `block`, and counts its energy. `deposit`: its part on the card, of
// all words together.
void add_to_block(std::uint32_t block, const Deposit& deposit, const Interaction& interaction, const RayState& from,
                  const Frame& frame, RayCounters& counters);

}  // namespace gicube::emu

// What a sample does to a ray where there is more to it than gathering: lighting rays, and rendering rays that are lit by
// irradiance or scattered [P §2.2]. Pure functions of the ray and the volume, for every fidelity level.
//
// A sample stands for the step that follows it; a lighting ray's, with the conserving rules, for its part of the ray
// (ray_part.h). Absorption and scattering share its opacity a (docs/reference/hardware.md):
//   low albedo    the ray keeps 1 - (1 - Ks) a of its energy, or of its transparency, and deposits the rest; of what is
//                 kept the part Ks a / (1 - (1 - Ks) a) is scattered
//   high albedo   the ray meets the material when a, accumulated, reaches its interaction value, and is then scattered with
//                 probability Ks, else absorbed whole
#pragma once

#include <optional>

#include "datapath/random_stream.h"
#include "datapath/ray_step.h"
#include "datapath/scatter.h"
#include "datapath/scattering.h"
#include "gicube/wire/trap.h"

namespace gicube::emu {

// The pipeline's words at a place.
struct Sample {
  Channels channels{};  // density, gradient
  unsigned tag = 0;
  wire::SegmentationEntry entry{};  // in the voxels' colour
  std::size_t index = 0;            // of it

  Point gradient() const { return point_of(channels); }
};

Sample sample_at(const Point& position, const Frame& frame);

// Whole units of energy for each irradiance word.
using EnergyUnits = std::array<std::uint32_t, kColours>;

enum class Outcome : std::uint8_t { kGoesOn, kEnded, kTrapped };

struct Interaction {
  Outcome outcome = Outcome::kGoesOn;
  bool visible = false;  // the sample has an opacity
  bool deposits = false;
  // If it does: where, not always in the block of the sample; how much; and on which flight.
  Deposit deposit;  // in three irradiance words: the sums of their shares
  Point place{};
  EnergyUnits units{};  // for each word; in sums: signed
  std::uint16_t lifetime = 0;
};

// A deposit of no energy round `place`.
Deposit nothing_at(const Point& place);

// Gives `units` to the voxels round `place`, if they are any.
void deposit(Interaction& interaction, const RayState& ray, const EnergyUnits& units, const Point& place,
             const Frame& frame);

// What a sample at `place` of a ray that backprojects leaves in sums.
Deposit spread_at(const Point& place, std::int32_t amount);

// What an irradiance carrier brings: the energy is shared among the voxels round its position as by the ray that sent it.
Interaction brought_by(const RayState& carrier, const Frame& frame);

// What a deposit of `ray`, or its carrier, leaves in one of three irradiance words.
Deposit deposit_in(std::size_t word, const Interaction& interaction, const RayState& ray, const Frame& frame);

// Takes a sample, and advances or scatters the ray.
Interaction interact(RayState& ray, const SampleSite& site, const Frame& frame, RayCounters& counters);

// Begins a new flight of a scattered ray, along `direction`.
void redirect(RayState& ray, const Direction& direction, const Frame& frame);

// A leap takes the ray through nothing: it is no longer at a surface.
inline void leave_surface(RayState& ray) { ray.flags &= static_cast<std::uint8_t>(~wire::kTrapped); }

// Whether rays leap over the block.
inline bool is_leapt_over(std::size_t block, const Frame& frame) { return frame.leap && frame.empty[block] != 0; }

// One pass through the pipeline of a ray that has not come to its end is one of these three.

// It leaps over its empty block, whose least corner is `low` and whose edge `size`. Returns how many steps it went.
inline std::int32_t leap(RayState& ray, const Point& low, std::int32_t size, const Frame& frame,
                         RayCounters& counters) {
  jitter_step(ray, frame);
  ++counters.leaps;
  leave_surface(ray);
  ray.under_way = true;
  const std::int32_t steps = leap_steps(ray, low, size, frame);
  advance(ray, steps, frame);
  count_steps(ray, steps, frame);
  return steps;
}

// It gathers a sample: in a plain frame.
inline void gather(RayState& ray, const SampleSite& site, const Frame& frame, RayCounters& counters) {
  jitter_step(ray, frame);
  ++counters.samples;
  if (take_sample(ray, site, frame)) ++counters.visible_samples;
  advance(ray, 1, frame);
  count_steps(ray, 1, frame);
}

// It takes a sample that may also deposit, scatter or end it: in any other frame.
inline Interaction sample(RayState& ray, const SampleSite& site, const Frame& frame, RayCounters& counters) {
  jitter_step(ray, frame);
  ++counters.samples;
  const Interaction interaction = interact(ray, site, frame, counters);
  if (interaction.visible) ++counters.visible_samples;
  count_steps(ray, 1, frame);
  return interaction;
}

// Applies the host's answer (trap.h) to a ray that waited for it. Returns true if the ray ends by it: the packet is then as
// pack() leaves it, else ready for unpack(). The energy that it brings counts as emitted.
bool take_answer(wire::Ray& ray, const Frame& frame, RayCounters& counters);

// What a routine on the DSP must answer.
struct Trap {
  std::uint8_t routine = 0;
  ScatterEvent event;
};

// Of a trapped ray. Nothing: the host must answer; the frame's HostTrapQueue has the ray.
std::optional<Trap> trap_of(RayState& ray, const Frame& frame);

// The trapped ray goes on as the routine says, or ends. The DSP's cycles are counted.
Interaction answer_trap(RayState& ray, const ScatterAnswer& answer, const Frame& frame, RayCounters& counters);

// Opacity at which the ray interacts, 24 bits; the packet has 12 of them, the wide datapath all. The printed rules keep one
// value for the whole path [P §2.2], which correlates its flights.
std::uint32_t interaction_value(const RayState& ray, const Frame& frame);

// What is added to an energy before its fraction is cut off: one draw a ray.
inline std::uint32_t energy_phase(const RayState& ray, const Frame& frame) {
  return static_cast<std::uint32_t>(draw(RandomStream::kPhase, ray.u, ray.v, 0, frame.seed) >>
                                    (64 - kEnergyFractionBits));
}
// The whole energy units that the ray holds for an irradiance word. Its fraction is rounded by one draw a ray, so that its deposits
// sum exactly to the energy that it had.
inline std::uint32_t energy_units(const RayState& ray, const Frame& frame, std::size_t word = 0) {
  return static_cast<std::uint32_t>((ray.energy(word) + energy_phase(ray, frame)) >> kEnergyFractionBits);
}
EnergyUnits all_units(const RayState& ray, const Frame& frame);  // for each word
// Of a ray that sets out.
void count_emitted(const RayState& ray, const Frame& frame, RayCounters& counters);

// Opacity of one voxel length at a place of the volume, 65535 = 1.
std::uint16_t opacity_at(const Point& position, const Frame& frame);

// Counts a ray that has come to its end, with the energy that leaves with it.
void count_end(const RayState& ray, Termination how, const Frame& frame, RayCounters& counters);

}  // namespace gicube::emu

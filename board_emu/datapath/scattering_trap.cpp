// Trapped rays: the event for a routine, and the continuation of the ray by its answer.
#include <span>

#include "datapath/host_traps.h"
#include "datapath/interaction.h"
#include "datapath/random_stream.h"
#include "datapath/scattering.h"

namespace gicube::emu {

static_assert(wire::kTrapDensityFractionBits == kDensityFractionBits &&
              static_cast<int>(wire::kTrapOpacityOne) == wire::kClassifiedOpacityOne);

namespace {

// Takes the sample again, because the ray has moved within its step to the point of interaction.
wire::TrappedRay trapped_ray(const RayState& ray, unsigned tag, const Frame& frame) {
  const Sample sample = sample_at(ray.position, frame);
  wire::TrappedRay out;
  out.ray = pack(ray, frame);
  for (std::size_t axis = 0; axis < 3; ++axis) out.gradient[axis] = sample.channels[axis + 1];
  out.density = static_cast<std::uint16_t>(sample.channels[0]);
  out.opacity = sample.entry.opacity;
  out.tag = static_cast<std::uint8_t>(tag);
  std::uint64_t chance = draw_at(RandomStream::kRoutine, ray.position, ray.u, ray.v, ray.lifetime, frame.seed);
  for (std::uint32_t& number : out.random) {
    number = static_cast<std::uint32_t>(chance >> 32);
    chance = wire::mix64(chance + 1);
  }
  return out;
}

ScatterEvent event_of(const wire::TrappedRay& trapped, const wire::Material& material, const Frame& frame) {
  ScatterEvent event;
  event.direction = wire::physical_direction(trapped.ray.direction, frame.spacing);
  event.normal = wire::surface_normal(trapped.gradient);
  for (std::size_t axis = 0; axis < 3; ++axis) event.position[axis] = trapped.ray.position[axis] / double{wire::kVoxel};
  event.opacity = trapped.opacity / wire::kTrapOpacityOne;
  event.density = trapped.density / double{1 << wire::kTrapDensityFractionBits};
  event.tag = trapped.tag;
  event.lighting = (trapped.ray.flags & wire::kLightingRay) != 0;
  event.generation = trapped.ray.generation;
  event.parameters = std::span(material.parameters).first(material.parameter_count);
  for (std::size_t i = 0; i < 4; ++i) event.random[i] = trapped.random[i] * 0x1p-32;
  return event;
}

// Continues the ray along `direction`, or ends it if all of it is dropped; `dropped`: 2^24 - 1 = all.
Interaction go_on(RayState& ray, const Direction& direction, std::uint32_t dropped, const Frame& frame,
                  RayCounters& counters) {
  Interaction interaction;
  if (dropped != 0) {
    const bool lighting = ray.is(wire::kLightingRay);
    bool any_left = false;
    if (lighting) {
      for (std::size_t word = 0; word < frame.light_words; ++word) {
        const std::uint32_t before = energy_units(ray, frame, word);
        const std::uint64_t e = ray.energy(word);
        ray.set_energy(word, e - (e * dropped + wire::kOpacityOne / 2) / wire::kOpacityOne);
        const std::uint32_t left = energy_units(ray, frame, word);
        counters.energy_of(word).scattered_away += before - left;
        any_left = any_left || left != 0;
      }
    } else if (gathers_wide(frame)) {
      over(ray, ray.wide, {0, 0, 0}, static_cast<float>(dropped) / static_cast<float>(wire::kOpacityOne));
    } else {
      over(ray, {0, 0, 0}, dropped);
    }
    if (dropped == wire::kOpacityOne || (lighting && !any_left)) {
      interaction.outcome = Outcome::kEnded;
      return interaction;
    }
  }
  redirect(ray, direction, frame);
  return interaction;
}

}  // namespace

bool take_answer(wire::Ray& ray, const Frame& frame, RayCounters& counters) {
  RayState ray_state = unpack(ray, frame);
  if (ray_state.is(wire::kLightingRay)) count_emitted(ray_state, frame, counters);
  const bool ends =
      go_on(ray_state, ray.direction, wire::dropped_share(ray), frame, counters).outcome == Outcome::kEnded;
  if (ends) count_end(ray_state, Termination::kAbsorbed, frame, counters);
  ray = pack(ray_state, frame);
  return ends;
}

std::optional<Trap> trap_of(RayState& ray, const Frame& frame) {
  const unsigned tag = ray.flags >> kTrapTagShift;
  const wire::Material& material = frame.materials[tag];
  ray.flags &= (1u << kTrapTagShift) - 1;
  if ((material.flags & wire::kTrapAtSurface) == 0) leave_surface(ray);
  const wire::TrappedRay trapped = trapped_ray(ray, tag, frame);
  if (material.routine != wire::kHostRoutine) return Trap{material.routine, event_of(trapped, material, frame)};
  frame.host_traps->add(trapped);
  return std::nullopt;
}

Interaction answer_trap(RayState& ray, const ScatterAnswer& answer, const Frame& frame, RayCounters& counters) {
  counters.trap_cycles += answer.cycles;
  return go_on(ray, wire::direction_words(answer.direction, frame.spacing), wire::dropped_share(answer.passes), frame,
               counters);
}

}  // namespace gicube::emu

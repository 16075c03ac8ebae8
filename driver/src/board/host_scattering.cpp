// Calls the application's scattering routine for trapped rays (gicube/wire/trap.h).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "encode/vectors.h"
#include "gicube/wire/command.h"
#include "gicube/wire/registers.h"
#include "state.h"

namespace gicube {
namespace {

constexpr std::size_t kRaysPerRound = 4096;  // chosen: 256 KB up per round

struct TrapList {
  std::vector<wire::TrappedRay> rays;
  std::uint32_t waiting = 0;  // further ones on the board
};

ScatterEvent event_of(const wire::TrappedRay& trapped, const Material& material, const wire::Spacing& spacing) {
  ScatterEvent event;
  wire::Triple position{};
  for (std::size_t axis = 0; axis < 3; ++axis) position[axis] = trapped.ray.position[axis] / double{wire::kVoxel};
  event.position = to_vec3(position);
  event.direction = to_vec3(wire::physical_direction(trapped.ray.direction, spacing));
  event.normal = to_vec3(wire::surface_normal(trapped.gradient));
  event.opacity = trapped.opacity / wire::kTrapOpacityOne;
  event.density = trapped.density / double{1 << wire::kTrapDensityFractionBits};
  event.tag = trapped.tag;
  event.lighting = (trapped.ray.flags & wire::kLightingRay) != 0;
  event.generation = trapped.ray.generation;
  for (std::size_t i = 0; i < 4; ++i) event.random[i] = trapped.random[i] * 0x1p-32;
  event.parameters = material.parameters;
  return event;
}

void check(const ScatterAnswer& answer) {
  const Vec3& d = answer.direction;
  const double length = std::hypot(d.x, d.y, d.z);
  if (!(length >= wire::kShortestDirection && length <= wire::kLongestDirection)) {
    throw ScatteringFailed(fmt::format(
        "direction: expected a length of 1e-6 to 1e6 from the scattering routine, got {} {} {}", d.x, d.y, d.z));
  }
  if (answer.passes >= 0 && answer.passes <= 1) return;
  throw ScatteringFailed(fmt::format("passes: expected 0..1 from the scattering routine, got {}", answer.passes));
}

// Makes the packet with the routine's answer to `trapped`. Throws ScatteringFailed, and what the routine throws.
wire::Ray answer(const wire::TrappedRay& trapped, const Material& material, const wire::Spacing& spacing,
                 const ScatteringRoutine& routine) {
  const ScatterAnswer answered = routine(event_of(trapped, material, spacing));
  check(answered);
  wire::Ray ray = trapped.ray;
  const Vec3& d = answered.direction;
  ray.direction = wire::direction_words({d.x, d.y, d.z}, spacing);
  wire::set_dropped_share(ray, wire::dropped_share(answered.passes));
  return ray;
}

// Makes the command that sends these packets and asks for at most `max_rays` more trapped rays.
std::vector<std::uint8_t> resume_command(std::span<const wire::Ray> answers, std::uint32_t max_rays) {
  std::vector<std::uint8_t> bytes =
      wire::encoded(wire::ResumeHeader{static_cast<std::uint32_t>(answers.size()), max_rays});
  for (const wire::Ray& ray : answers) wire::append(bytes, ray);
  return bytes;
}

// Returns false if the bytes are not a trap list. No bytes are an empty list.
bool decode_trap_list(std::span<const std::uint8_t> bytes, TrapList& list) {
  list = {};
  if (bytes.empty()) return true;
  if (bytes.size() < wire::kTrapListHeaderBytes) return false;
  const auto [count, waiting] = wire::decode<wire::TrapListHeader>(bytes);
  list.waiting = waiting;
  bytes = bytes.subspan(wire::kTrapListHeaderBytes);
  if (bytes.size() != std::uint64_t{count} * wire::kTrappedRayBytes) return false;
  list.rays.reserve(count);
  for (std::size_t at = 0; at < bytes.size(); at += wire::kTrappedRayBytes) {
    list.rays.push_back(wire::decode<wire::TrappedRay>(bytes.subspan(at)));
    if (list.rays.back().tag >= wire::kTags) return false;
  }
  return true;
}

}  // namespace

void LookUpTables::set_scattering_routine(ScatteringRoutine routine, Picoseconds time_per_ray) {
  const auto lock = state_->begin();
  state_->scattering_routine = std::move(routine);
  state_->time_per_scattering = time_per_ray;
}

void BoardState::need_routine(bool lighting) const {
  if (scattering_routine) return;
  const auto& materials = tables.materials();
  for (std::size_t tag = 0; tag < materials.size(); ++tag) {
    const Material& material = materials[tag];
    const bool asks_host = material.bsdf == Bsdf::kTrap && material.routine == kHostRoutine;
    if (!asks_host || !(lighting || material.seen_through_scattering)) continue;
    throw Rejected(fmt::format(
        "the material of tag {} is scattered by the application: call set_scattering_routine() first", tag));
  }
}

void BoardState::scatter_waiting(std::span<const std::uint8_t> trap_list, const TakeLedger& take_ledger) {
  TrapList list;
  if (!decode_trap_list(trap_list, list)) device.give_up("a list of trapped rays of wrong size");
  if (list.rays.empty() && list.waiting == 0) return;
  if (!scattering_routine) device.give_up("the board sent trapped rays, but no scattering routine is set");
  const wire::Spacing spacing = spacing_words(volume->relative_spacing);
  const std::uint16_t minor = device.agreed().minor;
  const std::size_t ledger_bytes = take_ledger ? wire::lighting_ledger_bytes(minor) : 0;
  const std::size_t room = device.agreed().max_payload_bytes - wire::kTrapListHeaderBytes - ledger_bytes;
  const std::size_t max_rays = std::min(kRaysPerRound, room / wire::kTrappedRayBytes);
  std::vector<wire::Ray> answers;
  while (!answers.empty() || list.waiting > 0) {
    const CommandResult result = device.run(resume_command(answers, static_cast<std::uint32_t>(max_rays)), {});
    std::span<const std::uint8_t> payload = result.payload;
    if (payload.size() < ledger_bytes) device.give_up("a lighting result of wrong size");
    if (take_ledger) take_ledger(wire::decode_lighting_ledger(payload, minor));
    if (!decode_trap_list(payload.subspan(ledger_bytes), list) || list.rays.size() > max_rays) {
      device.give_up("a list of trapped rays of wrong size");
    }
    answers.clear();
    for (const wire::TrappedRay& trapped : list.rays) {
      const InCallback mark(*this);
      answers.push_back(answer(trapped, tables.materials()[trapped.tag], spacing, scattering_routine));
    }
    device.clock().work(time_per_scattering * answers.size());
  }
}

}  // namespace gicube

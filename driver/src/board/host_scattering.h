// The application's scattering routine, and trapped rays in the words of the bus (gicube/wire/trap.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gicube/material.h"
#include "gicube/scattering.h"
#include "gicube/time.h"
#include "gicube/wire/trap.h"

namespace gicube {

struct HostScattering {
  ScatteringRoutine routine;
  Picoseconds time_per_ray = 0;
};

bool asks_host(const Material& material);

// The packet that answers `trapped`. Throws ScatteringFailed, and what the routine throws.
wire::Ray answer(const wire::TrappedRay& trapped, const Material& material, const wire::Spacing& spacing,
                 const ScatteringRoutine& routine);

// A command that sends these packets down and asks for at most `max_rays` more rays.
std::vector<std::uint8_t> resume_command(std::span<const wire::Ray> answers, std::uint32_t max_rays);

struct TrapList {
  std::vector<wire::TrappedRay> rays;
  std::uint32_t waiting = 0;  // on the board, beyond these
};
// False if the bytes are no trap list; no bytes at all are an empty one.
bool decode_trap_list(std::span<const std::uint8_t> bytes, TrapList& list);

}  // namespace gicube

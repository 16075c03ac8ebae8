// Random numbers of a ray, hashed from its state: every fidelity level, order and thread draws the same (board's bit
// exactness). The hardware would mix the same bits into the index of a LUT [P §3.4].
#pragma once

#include <array>
#include <cstdint>

#include "datapath/jitter.h"

namespace gicube::emu {

// What a number is drawn for: draws of one ray at one place must not repeat each other.
enum class RandomStream : std::uint64_t {
  kInteraction = 1,
  kPhase,
  kAbsorption,
  kDirection,
  kSplat,
  kShare,
  kRoutine,
  kLoss,
  kColour
};

// 64 bits for the ray (u, v) on a flight: `lifetime` names the flight. `seed` is the SEED register.
constexpr std::uint64_t draw(RandomStream what, std::uint16_t u, std::uint16_t v, std::uint16_t lifetime,
                             std::uint32_t seed) {
  const std::uint64_t ray = u | std::uint64_t{v} << 16 | std::uint64_t{lifetime} << 32;
  return mix64(mix64(ray) ^ (std::uint64_t{seed} << 8 | static_cast<std::uint64_t>(what)));
}

// The same at a place.
constexpr std::uint64_t draw_at(RandomStream what, const std::array<std::int32_t, 3>& position, std::uint16_t u,
                                std::uint16_t v, std::uint16_t lifetime, std::uint32_t seed) {
  const std::uint64_t low =
      static_cast<std::uint32_t>(position[0]) | std::uint64_t{static_cast<std::uint32_t>(position[1])} << 32;
  const std::uint64_t here = mix64(mix64(low) ^ static_cast<std::uint32_t>(position[2]));
  return mix64(here ^ draw(what, u, v, lifetime, seed));
}

}  // namespace gicube::emu

// Random numbers of a ray, hashed from its state: they are the same in every fidelity level, order and thread (bit
// exactness). Hardware would hash the same bits to the index of a LUT [P §3.4] [H924].
#pragma once

#include <array>
#include <cstdint>

#include "datapath/jitter.h"

namespace gicube::emu {

// Purpose of a number: draws of one ray at one position must be independent.
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

// 64 bits for the ray (u, v) on the path segment identified by `lifetime`. `seed` is the SEED register.
constexpr std::uint64_t draw(RandomStream what, std::uint16_t u, std::uint16_t v, std::uint16_t lifetime,
                             std::uint32_t seed) {
  const std::uint64_t ray = u | std::uint64_t{v} << 16 | std::uint64_t{lifetime} << 32;
  return wire::mix64(wire::mix64(ray) ^ (std::uint64_t{seed} << 8 | static_cast<std::uint64_t>(what)));
}

// draw() that also depends on a position.
constexpr std::uint64_t draw_at(RandomStream what, const std::array<std::int32_t, 3>& position, std::uint16_t u,
                                std::uint16_t v, std::uint16_t lifetime, std::uint32_t seed) {
  const std::uint64_t low =
      static_cast<std::uint32_t>(position[0]) | std::uint64_t{static_cast<std::uint32_t>(position[1])} << 32;
  const std::uint64_t here = wire::mix64(wire::mix64(low) ^ static_cast<std::uint32_t>(position[2]));
  return wire::mix64(here ^ draw(what, u, v, lifetime, seed));
}

}  // namespace gicube::emu

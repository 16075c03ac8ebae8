// The spacing unit's random factor: position and image destination are hashed to an index into a LUT of numbers between
// 1/2 and 1 [P §2.1, §3.4]. The same ray at the same position always draws the same number (bit exactness) [H803].
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gicube/wire/mix64.h"

namespace gicube::emu {

inline constexpr std::size_t kJitterEntries = 256;  // chosen
inline constexpr std::uint32_t kJitterOne = 1u << 16;

// Stratified: entry i of a shuffled order is 1/2 + (i + 1/2) / 512, so the mean is exactly 3/4.
constexpr std::array<std::uint32_t, kJitterEntries> make_jitter_lut() {
  std::array<std::uint32_t, kJitterEntries> lut{};
  for (std::size_t i = 0; i < kJitterEntries; ++i) {
    lut[i] = kJitterOne / 2 + static_cast<std::uint32_t>((2 * i + 1) * (kJitterOne / 2) / (2 * kJitterEntries));
  }
  for (std::size_t i = kJitterEntries - 1; i > 0; --i) {
    const std::size_t j = wire::mix64(i) % (i + 1);
    const std::uint32_t swapped = lut[i];
    lut[i] = lut[j];
    lut[j] = swapped;
  }
  return lut;
}

inline constexpr auto kJitterLut = make_jitter_lut();

// The factor r of the sample at `position` of the ray with destination bits (u, v); 16 fraction bits.
constexpr std::uint32_t jitter(const std::array<std::int32_t, 3>& position, std::uint16_t u, std::uint16_t v) {
  const std::uint64_t low =
      static_cast<std::uint32_t>(position[0]) | std::uint64_t{static_cast<std::uint32_t>(position[1])} << 24;
  const std::uint64_t high = static_cast<std::uint32_t>(position[2]) | std::uint64_t{u} << 24 | std::uint64_t{v} << 40;
  return kJitterLut[wire::mix64(wire::mix64(low) ^ high) % kJitterEntries];
}

}  // namespace gicube::emu

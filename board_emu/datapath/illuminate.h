// Lights a sample of a rendering ray by the irradiance of its voxels [P §3.4].
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "datapath/resample.h"
#include "datapath/shade.h"
#include "gicube/wire/lut.h"

namespace gicube::emu {

// The irradiance at a sample, 11.4. `cell` points to the word of least coordinates.
inline std::uint32_t irradiance(const std::uint32_t* cell, std::size_t row, std::size_t slice,
                                const std::array<int, 3>& weights, bool narrow) {
  const auto word = [cell, narrow](std::size_t i) { return irradiance_word(cell[i], narrow); };
  return static_cast<std::uint32_t>(std::max<std::int16_t>(resample_words({0, row, slice, weights}, word), 0));
}

// Colour of a classified sample lit by red, green and blue irradiance, which gives the diffuse part. `exposure`: 16.16.
inline Colour12 illuminated(const wire::SegmentationEntry& entry, const std::array<std::uint32_t, 3>& irradiance,
                            std::uint32_t exposure, const Point& gradient, const std::uint8_t* reflectance_map) {
  constexpr int kTooMany = kIrradianceFractionBits + wire::kGainFractionBits + 16 - kShadeFractionBits;
  Colour12 lit;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::uint64_t gained = std::uint64_t{irradiance[c]} * entry.gain();
    lit[c] = static_cast<std::int32_t>(std::min<std::uint64_t>((gained * exposure + (1u << (kTooMany - 1))) >> kTooMany,
                                                               std::uint64_t{8} << kShadeFractionBits));
  }
  return illuminated(shading_entry(entry), std::int32_t{entry.specular}, lit, gradient, SquareOf{reflectance_map});
}

}  // namespace gicube::emu

// Local shading by the reflectance map [P §2.1, §3.4]: the sample's normal selects an intensity on a cube map.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gicube/wire/lut.h"
#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

inline constexpr int kShadeFractionBits = 15;  // bits of interpolated intensities and shades
inline constexpr std::int32_t kShadeUnit = 1 << kShadeFractionBits;

// Shorter interpolated gradients have no reliable direction: such a sample is not shaded. 1/16 of a unit vector.
inline constexpr std::int32_t kGradientUnit = wire::kGradientOne << kGradientFractionBits;
inline constexpr std::int32_t kShortestGradient = kGradientUnit / 16;  // chosen

// Bilinear reflectance of the normal opposite to `gradient`, which is not zero; 15 fraction bits. The map's `texels` are
// wire::kReflectanceBytes. The one division is IEEE single precision, correctly rounded, hence the same on every machine and
// SIMD width.
inline std::int32_t reflectance(const std::uint8_t* texels, const Point& gradient) {
  const Point normal{-gradient[0], -gradient[1], -gradient[2]};
  const Point size{std::abs(normal[0]), std::abs(normal[1]), std::abs(normal[2])};
  std::size_t axis = size[1] > size[0] ? 1 : 0;
  if (size[2] > size[axis]) axis = 2;
  const std::int32_t b = normal[axis == 0 ? 1 : 0], c = normal[axis == 2 ? 1 : 2];
  const std::size_t face = 2 * axis + (normal[axis] < 0 ? 1 : 0);

  // Maps [-1, 1] to texel 0..127 with 8 fraction bits.
  constexpr float kHalfRow = 127 * 128;
  const auto major = static_cast<float>(size[axis]);
  const auto to_texel = [major](std::int32_t minor) {
    const float ratio = static_cast<float>(minor) / major;
    return static_cast<std::int32_t>(std::lrintf(ratio * kHalfRow)) + 127 * 128;
  };
  const std::int32_t column = to_texel(b), row = to_texel(c);
  const std::int32_t i = std::min(column >> 8, wire::kReflectanceSize - 2);
  const std::int32_t j = std::min(row >> 8, wire::kReflectanceSize - 2);
  const std::int32_t s = column - (i << 8), t = row - (j << 8);  // 0..256

  const std::uint8_t* texel =
      texels + (face * wire::kReflectanceSize + static_cast<std::size_t>(j)) * wire::kReflectanceSize + i;
  const std::int32_t top = texel[0] * (256 - s) + texel[1] * s;
  const std::int32_t bottom = texel[wire::kReflectanceSize] * (256 - s) + texel[wire::kReflectanceSize + 1] * s;
  const std::int32_t sum = top * (256 - t) + bottom * t;  // 7 + 16 fraction bits
  return (sum + 128) >> 8;
}

using Colour12 = std::array<std::int32_t, 3>;  // 4095 = one

// A classified sample's colour, shaded by its interpolated gradient.
inline Colour12 shade(const wire::SegmentationEntry& entry, const Point& gradient,
                      const std::uint8_t* reflectance_map) {
  if (dot(gradient, gradient) < std::int64_t{kShortestGradient} * kShortestGradient) {
    return {entry.colour[0], entry.colour[1], entry.colour[2]};
  }
  constexpr int kCoefficientShift = kShadeFractionBits - 7;  // from units of 1/128
  const std::int32_t intensity = reflectance(reflectance_map, gradient);
  const std::int32_t total = (entry.ambient << kCoefficientShift) + ((entry.reflect * intensity + 64) >> 7);
  const std::int32_t base = std::min(total, entry.knee << kCoefficientShift);
  const std::int32_t highlight = total - base;
  Colour12 out{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    // Up to 4095 * 2 * 2^15 + 4095 * 6 * 2^15: more than 31 bits.
    const std::int64_t lit = std::int64_t{entry.colour[channel]} * base + std::int64_t{wire::kColourOne} * highlight;
    out[channel] = static_cast<std::int32_t>(
        std::min<std::int64_t>((lit + kShadeUnit / 2) >> kShadeFractionBits, wire::kColourOne));
  }
  return out;
}

}  // namespace gicube::emu

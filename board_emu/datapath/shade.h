// Local shading by the reflectance map [P §2.1, §3.4]: the sample's normal selects an intensity on a cube map.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "datapath/one_lane.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

inline constexpr int kShadeFractionBits = 15;  // bits of interpolated intensities and shades
inline constexpr std::int32_t kShadeUnit = 1 << kShadeFractionBits;

// Shorter interpolated gradients have no reliable direction: such a sample is not shaded. 1/16 of a unit vector.
inline constexpr std::int32_t kGradientUnit = wire::kGradientOne << kGradientFractionBits;
inline constexpr std::int32_t kShortestGradient = kGradientUnit / 16;  // chosen

using Colour12 = std::array<std::int32_t, 3>;  // 4095 = one

#include "datapath/shading-inl.h"

// Texels of a map of wire::kReflectanceBytes, for reflectance().
struct SquareOf {
  const std::uint8_t* texels;

  std::int32_t operator()(std::int32_t i) const {
    const std::uint8_t *const top = texels + i, *const bottom = top + wire::kReflectanceSize;
    return static_cast<std::int32_t>(top[0] | top[1] << 8 | bottom[0] << 16 | std::uint32_t{bottom[1]} << 24);
  }
};
inline std::int32_t reflectance(const std::uint8_t* texels, const Point& gradient) {
  return reflectance(gradient, SquareOf{texels});
}

inline ShadingEntry<std::int32_t> shading_entry(const wire::SegmentationEntry& entry) {
  return {{entry.colour[0], entry.colour[1], entry.colour[2]}, entry.ambient, entry.reflect, entry.knee};
}

inline Colour12 shade(const wire::SegmentationEntry& entry, const Point& gradient,
                      const std::uint8_t* reflectance_map) {
  return shade(shading_entry(entry), gradient, SquareOf{reflectance_map});
}

}  // namespace gicube::emu

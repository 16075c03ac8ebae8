// Words of the look-up tables: segmentation (classification), gradient decoding, reflectance map.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gicube/wire/record.h"
#include "gicube/wire/voxel.h"

namespace gicube::wire {

// Segmentation LUT: 2^14 entries, index = tag << 12 | density [P §3.4, Table 1]. A word has 84 bits, or 96 with those
// of the wide datapath (README.md). shade = ambient + reflect * map(normal). The part above `knee` is a highlight,
// which goes to white; the rest scales the colour (docs/reference/hardware.md).
inline constexpr std::size_t kSegmentationEntries = std::size_t{1} << 14;
inline constexpr std::uint16_t kClassifiedOpacityOne = 65535;
inline constexpr std::uint8_t kShadeOne = 128;
inline constexpr int kGainFractionBits = 8;
inline constexpr int kFineOpacityOne = 4096;  // scale of opacity_fine

struct SegmentationEntry {
  std::array<std::uint16_t, 3> colour{};                            // red green blue, 4095 = 1
  std::uint16_t opacity = 0;                                        // opacity of one voxel length, 65535 = 1 exactly
  std::uint8_t ambient = 0, reflect = kShadeOne, knee = kShadeOne;  // shading coefficients in 1/128
  std::uint8_t specular = 0;      // the specular coefficient of samples lit by irradiance
  std::int16_t opacity_fine = 0;  // adds 1/4096 of the opacity's unit each, -2048..2047; wide datapath only

  constexpr void bits(auto&& list) {
    list(12, colour);
    list(16, opacity);
    list(8, ambient, reflect, knee, specular);
    list(12, opacity_fine);
  }
  // Opacity of one voxel length on the wide datapath, 0..1.
  constexpr double wide_opacity() const {
    const double units = opacity + opacity_fine / double{kFineOpacityOne};
    return units <= 0 ? 0 : units >= kClassifiedOpacityOne ? 1 : units / kClassifiedOpacityOne;
  }
  // Brightness of a unit of irradiance under EXPOSURE, 8.8: the reciprocal of the opacity, because a sample absorbs in
  // proportion to its opacity. Uses the bits of `reflect` and `knee`.
  constexpr std::uint32_t gain() const { return reflect | std::uint32_t{knee} << 8; }
  constexpr void set_gain(std::uint32_t gain) {
    reflect = static_cast<std::uint8_t>(gain);
    knee = static_cast<std::uint8_t>(gain >> 8);
  }
  friend constexpr bool operator==(const SegmentationEntry&, const SegmentationEntry&) = default;
};
inline constexpr std::size_t kSegmentationEntryBytes = bytes_of<SegmentationEntry>();

// Gradient LUT: 2048 words of 3 x 10 bits, signed, 511 = 1 [P §3.3]; one dword each on the bus. A vector is the unit
// direction of increasing density, in physical space. Code kNoGradient holds the zero vector.
inline constexpr int kGradientOne = 511;
inline constexpr std::size_t kGradientEntryBytes = 4;

using GradientEntry = std::array<std::int16_t, 3>;

constexpr std::uint32_t to_word(const GradientEntry& g) {
  return (static_cast<std::uint32_t>(g[0]) & 0x3FFu) | (static_cast<std::uint32_t>(g[1]) & 0x3FFu) << 10 |
         (static_cast<std::uint32_t>(g[2]) & 0x3FFu) << 20;
}

constexpr GradientEntry to_gradient(std::uint32_t word) {
  return {static_cast<std::int16_t>(sign_extend(word & 0x3FFu, 10)),
          static_cast<std::int16_t>(sign_extend(word >> 10 & 0x3FFu, 10)),
          static_cast<std::int16_t>(sign_extend(word >> 20 & 0x3FFu, 10))};
}

// Reflectance map: a cube of 6 faces x 128 x 128 bytes [P §3.4], intensity in 1/128 (255 is 1.99). The faces are +x -x
// +y -y +z -z of the surface normal (the opposite of the gradient). On the face of the major axis a, the other two axes
// b < c give the column from b/|a| and the row from c/|a|. Texels are corner-aligned: texel 0 is -1, texel 127 is +1.
inline constexpr int kReflectanceFaces = 6;
inline constexpr int kReflectanceSize = 128;
inline constexpr std::size_t kReflectanceBytes = std::size_t{kReflectanceFaces} * kReflectanceSize * kReflectanceSize;

}  // namespace gicube::wire

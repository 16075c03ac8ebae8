// The look-up tables' words: segmentation (classification), gradient decoding, reflectance map.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gicube/wire/bytes.h"
#include "gicube/wire/voxel.h"

namespace gicube::wire {

// Segmentation LUT: 2^14 entries, index = tag << 12 | density [P §3.4, Table 1]. 84 bits a word, three dwords on the bus:
//
//   bit   width  field
//     0  3 x 12  colour, red green blue, 4095 = 1
//    36      16  opacity of one voxel length, 65535 = 1 exactly
//    52       8  ambient      | shading coefficients in 1/128: shade = ambient + reflect * map(normal);
//    60       8  reflect      | what the shade has above `knee` is a highlight and goes to white,
//    68       8  knee         | the rest scales the colour (docs/reference/hardware.md)
//    76       8  specular     | of samples lit by irradiance
//    84      12  signed: adds 1/4096 of the opacity's unit each; read by the wide datapath alone
inline constexpr std::size_t kSegmentationEntries = std::size_t{1} << 14;
inline constexpr std::size_t kSegmentationEntryBytes = 12;
inline constexpr std::uint16_t kClassifiedOpacityOne = 65535;
inline constexpr std::uint8_t kShadeOne = 128;
inline constexpr int kGainFractionBits = 8;
inline constexpr int kFineOpacityOne = 4096;  // of opacity_fine

struct SegmentationEntry {
  std::array<std::uint16_t, 3> colour{};
  std::uint16_t opacity = 0;
  std::uint8_t ambient = 0;
  std::uint8_t reflect = kShadeOne;
  std::uint8_t knee = kShadeOne;
  std::uint8_t specular = 0;
  std::int16_t opacity_fine = 0;  // -2048 .. 2047

  // Opacity of one voxel length on the wide datapath, 0..1.
  constexpr double wide_opacity() const {
    const double units = opacity + opacity_fine / double{kFineOpacityOne};
    return units <= 0 ? 0 : units >= kClassifiedOpacityOne ? 1 : units / kClassifiedOpacityOne;
  }
  // Brightness of a unit of irradiance under EXPOSURE, 8.8: one over the opacity, since a sample absorbs in proportion to
  // it. Shares its bits with `reflect` and `knee`.
  constexpr std::uint32_t gain() const { return reflect | std::uint32_t{knee} << 8; }
  constexpr void set_gain(std::uint32_t gain) {
    reflect = static_cast<std::uint8_t>(gain);
    knee = static_cast<std::uint8_t>(gain >> 8);
  }
  friend constexpr bool operator==(const SegmentationEntry&, const SegmentationEntry&) = default;
};

inline void encode(const SegmentationEntry& entry, std::span<std::uint8_t, kSegmentationEntryBytes> out) {
  BitRecord<2> bits;
  for (unsigned c = 0; c < 3; ++c) bits.put(12 * c, 12, entry.colour[c]);
  bits.put(36, 16, entry.opacity);
  bits.put(52, 8, entry.ambient);
  bits.put(60, 8, entry.reflect);
  bits.put(68, 8, entry.knee);
  bits.put(76, 8, entry.specular);
  bits.put(84, 12, static_cast<std::uint64_t>(entry.opacity_fine) & 0xFFF);
  store(out, 0, bits.words[0]);
  store(out, 8, static_cast<std::uint32_t>(bits.words[1]));
}

inline SegmentationEntry decode_segmentation(std::span<const std::uint8_t, kSegmentationEntryBytes> in) {
  BitRecord<2> bits;
  bits.words[0] = load<std::uint64_t>(in, 0);
  bits.words[1] = load<std::uint32_t>(in, 8);
  SegmentationEntry entry;
  for (unsigned c = 0; c < 3; ++c) entry.colour[c] = static_cast<std::uint16_t>(bits.get(12 * c, 12));
  entry.opacity = static_cast<std::uint16_t>(bits.get(36, 16));
  entry.ambient = static_cast<std::uint8_t>(bits.get(52, 8));
  entry.reflect = static_cast<std::uint8_t>(bits.get(60, 8));
  entry.knee = static_cast<std::uint8_t>(bits.get(68, 8));
  entry.specular = static_cast<std::uint8_t>(bits.get(76, 8));
  entry.opacity_fine = static_cast<std::int16_t>(sign_extend(static_cast<std::uint32_t>(bits.get(84, 12)), 12));
  return entry;
}

// Gradient LUT: 2048 words of 3 x 10 bits, signed, 511 = 1 [P §3.3]; one dword each on the bus. The vector is the unit
// direction in which density grows, in physical space; code kNoGradient holds the zero vector.
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

// Reflectance map: a cube of 6 faces x 128 x 128 bytes [P §3.4], intensity in 1/128 (255 is 1.99). Faces +x -x +y -y +z -z
// of the surface normal (the opposite of the gradient). On the face of the major axis a the two others b < c follow in
// order: column from b/|a|, row from c/|a|; texels are corner-aligned: texel 0 is -1, texel 127 is +1.
inline constexpr int kReflectanceFaces = 6;
inline constexpr int kReflectanceSize = 128;
inline constexpr std::size_t kReflectanceBytes = std::size_t{kReflectanceFaces} * kReflectanceSize * kReflectanceSize;

}  // namespace gicube::wire

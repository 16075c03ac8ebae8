// The 36-bit voxel word and its packing: two voxels travel in nine bytes.
//
//   bit  width  field
//     0     12  density
//    12     11  gradient code (index into the gradient LUT)
//    23      2  material tag
//    25     11  irradiance
//
// Field list [P §2.1, Figure 4]; widths from the 36-bit cache word of Table 1 (docs/reference/hardware.md).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

inline constexpr int kVoxelBits = 36;
inline constexpr std::uint16_t kDensityMax = 4095;
inline constexpr std::uint16_t kGradientCodes = 2048;
inline constexpr std::uint16_t kNoGradient = 0;  // reserved for voxels without a gradient
inline constexpr int kTags = 4;

// Stored format of a voxel. The colours exceed the paper's 36 bits [P §5.6, future work: an expanded voxel format].
enum class VoxelFormat : std::uint32_t {
  kDensity = 1,  // the word below
  kRgb = 2,      // also a colour of kColourBytes, red first; the segmentation LUT gives its opacity by the density
  kRgba = 3,     // like kRgb, but the density is the colour's alpha: colours are interpolated premultiplied by it
};
inline constexpr std::size_t kColourBytes = 3;
constexpr bool has_colours(VoxelFormat format) { return format != VoxelFormat::kDensity; }
inline constexpr int kIrradianceBits = 11;  // on the paper's datapath
// `irradiance_words`: 1, or 3 for red, green and blue.
constexpr int voxel_bits(VoxelFormat format, std::uint32_t irradiance_words) {
  return kVoxelBits + (has_colours(format) ? 8 * static_cast<int>(kColourBytes) : 0) +
         (static_cast<int>(irradiance_words) - 1) * kIrradianceBits;
}

struct Voxel {
  std::uint16_t density = 0;
  std::uint16_t gradient = kNoGradient;
  std::uint8_t tag = 0;
  std::uint16_t irradiance = 0;

  friend constexpr bool operator==(const Voxel&, const Voxel&) = default;
};

constexpr std::uint64_t to_word(const Voxel& voxel) {
  return (voxel.density & 0xFFFu) | std::uint64_t{voxel.gradient & 0x7FFu} << 12 |
         std::uint64_t{voxel.tag & 0x3u} << 23 | std::uint64_t{voxel.irradiance & 0x7FFu} << 25;
}

constexpr Voxel to_voxel(std::uint64_t word) {
  return {static_cast<std::uint16_t>(word & 0xFFF), static_cast<std::uint16_t>(word >> 12 & 0x7FF),
          static_cast<std::uint8_t>(word >> 23 & 0x3), static_cast<std::uint16_t>(word >> 25 & 0x7FF)};
}

// Bytes of `count` packed 36-bit words; an odd count is padded by half a byte.
constexpr std::size_t packed36_bytes(std::size_t count) { return (count * kVoxelBits + 7) / 8; }

// Word `index` of a stream of 36-bit words. Framebuffer pixels use the same packing.
constexpr void store36(std::span<std::uint8_t> bytes, std::size_t index, std::uint64_t word) {
  const std::size_t at = index / 2 * 9;
  if (index % 2 == 0) {
    for (int i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(word >> (8 * i));
    bytes[at + 4] = static_cast<std::uint8_t>((bytes[at + 4] & 0xF0u) | (word >> 32 & 0xFu));
  } else {
    bytes[at + 4] = static_cast<std::uint8_t>((bytes[at + 4] & 0x0Fu) | (word & 0xFu) << 4);
    for (int i = 0; i < 4; ++i) bytes[at + 5 + i] = static_cast<std::uint8_t>(word >> (4 + 8 * i));
  }
}

constexpr std::uint64_t load36(std::span<const std::uint8_t> bytes, std::size_t index) {
  // Both words of a pair lie in eight of its nine bytes: the first one in the lower eight, the second one in the upper
  // eight.
  const std::size_t second = index % 2, at = index / 2 * 9 + second;
  std::uint64_t eight = 0;
  if (std::is_constant_evaluated() || std::endian::native != std::endian::little || at + 8 > bytes.size()) {
    for (std::size_t i = 0; i < 8 && at + i < bytes.size(); ++i) eight |= std::uint64_t{bytes[at + i]} << (8 * i);
  } else {
    std::memcpy(&eight, bytes.data() + at, sizeof eight);
  }
  return eight >> 28 * second & 0xF'FFFF'FFFFu;
}

// A framebuffer pixel, 8-8-8-12 rgb-alpha [P §3.6]: red in bits 0-7, green 8-15, blue 16-23, alpha 24-35.
// Colour is premultiplied by alpha; 255 and 4095 are one.
struct Pixel {
  std::uint8_t red = 0, green = 0, blue = 0;
  std::uint16_t alpha = 0;

  friend constexpr bool operator==(const Pixel&, const Pixel&) = default;
};

constexpr std::uint64_t to_word(const Pixel& pixel) {
  return pixel.red | std::uint64_t{pixel.green} << 8 | std::uint64_t{pixel.blue} << 16 |
         std::uint64_t{pixel.alpha & 0xFFFu} << 24;
}

constexpr Pixel to_pixel(std::uint64_t word) {
  return {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8), static_cast<std::uint8_t>(word >> 16),
          static_cast<std::uint16_t>(word >> 24 & 0xFFF)};
}

}  // namespace gicube::wire

// Opacity and compositing on the wide datapath [C]: a ray accumulates in floats, and a voxel's opacity has the table's
// 12 further bits. Lanes of rays repeat these operations one by one (functional/simd), without fused
// multiply-add, so that the bits are the same [H501-H509].
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "datapath/shade.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

// Accumulated values of a rendering ray. The opacity and colour of its packet are rounded from them.
struct WideWords {
  float opacity = 0;
  std::array<float, 3> colour{};  // premultiplied, 4095 = one
};

// The initial values of a ray: those of its packet.
template <typename Ray>
WideWords wide_words(const Ray& ray) {
  WideWords out;
  out.opacity = static_cast<float>(ray.opacity) / static_cast<float>(wire::kOpacityOne);
  for (std::size_t c = 0; c < 3; ++c) out.colour[c] = ray.colour[c];
  return out;
}

// 1 - 2^-x = x (c0 + c1 x + ...) for x in 0..1, with an error below 2.1 units of 2^-24 of its value, also near 0 (thin
// fog).
inline constexpr std::array<float, 7> kFall{0.693147182f,   -0.240226492f,    0.0555039123f,  -0.00961695053f,
                                            0.00132993993f, -0.000148892374f, 1.13038432e-05f};
inline constexpr float kOpaqueDepth = 64;  // beyond the range of the table's bits
inline constexpr float kMaxDepth = 31;     // per step; opaque

// Opacity of a sample that represents `exponent` (16.16) voxel lengths, each of which halves the light `depth` times.
inline float wide_alpha(float depth, std::uint32_t exponent) {
  if (depth >= kOpaqueDepth) return 1;
  const float lengths = static_cast<float>(static_cast<std::int32_t>(exponent)) * 0x1p-16f;
  const float x = std::min(depth * lengths, kMaxDepth);
  const auto whole = static_cast<std::int32_t>(x);
  const float rest = x - static_cast<float>(whole), left = std::bit_cast<float>((127 - whole) << 23);
  float fall = kFall.back();
  for (std::size_t i = kFall.size() - 1; i-- > 0;) fall = fall * rest + kFall[i];
  return (1 - left) + left * (fall * rest);
}

inline std::uint16_t to_colour_word(float colour) {
  return static_cast<std::uint16_t>(std::min(std::lrintf(colour), long{wire::kColourOne}));
}

// over() on the wide words; the packet's words are rounded from them.
template <typename Ray>
void over(Ray& ray, WideWords& wide, const Colour12& colour, float alpha) {
  const float weight = (1 - wide.opacity) * alpha;
  for (std::size_t c = 0; c < 3; ++c) {
    wide.colour[c] = wide.colour[c] + weight * static_cast<float>(colour[c]);
    ray.colour[c] = to_colour_word(wide.colour[c]);
  }
  wide.opacity = alpha == 1 ? 1 : wide.opacity + weight;
  ray.opacity = static_cast<std::uint32_t>(std::lrintf(wide.opacity * static_cast<float>(wire::kOpacityOne)));
}

// The segmentation LUT's opacities as halvings of the light per voxel length; kOpaqueDepth: opaque.
inline std::vector<float> wide_depths(std::span<const wire::SegmentationEntry> entries) {
  std::vector<float> out;
  out.reserve(entries.size());
  for (const wire::SegmentationEntry& entry : entries) {
    const double opacity = entry.wide_opacity();
    out.push_back(opacity >= 1 ? kOpaqueDepth : static_cast<float>(-std::log1p(-opacity) / std::log(2.0)));
  }
  return out;
}

}  // namespace gicube::emu

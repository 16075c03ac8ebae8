// Opacity and compositing on the wide datapath [C]: what a ray has gathered is kept in floats, and a voxel's opacity has the
// table's 12 further bits. Lanes of rays repeat these operations one by one (functional/simd/stages-inl.h): no fused
// multiply-add, so that the bits are the same.
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

// What a rendering ray has gathered. Its packet's opacity and colour follow, rounded.
struct WideWords {
  float opacity = 0;
  std::array<float, 3> colour{};  // premultiplied, 4095 = one
};

// Of a ray that sets out with what its packet holds.
template <typename Ray>
WideWords wide_words(const Ray& ray) {
  WideWords out;
  out.opacity = static_cast<float>(ray.opacity) / static_cast<float>(wire::kOpacityOne);
  for (std::size_t c = 0; c < 3; ++c) out.colour[c] = ray.colour[c];
  return out;
}

// 1 - 2^-x = x (c0 + c1 x + ...) for x in 0..1, within 2.1 units of 2^-24 of itself, also near 0: thin fog keeps its digits.
inline constexpr std::array<float, 7> kFall{0.693147182f,   -0.240226492f,    0.0555039123f,  -0.00961695053f,
                                            0.00132993993f, -0.000148892374f, 1.13038432e-05f};
inline constexpr float kOpaqueDepth = 64;  // beyond what the table's bits can say
inline constexpr float kMaxDepth = 31;     // of a step; nothing is seen through it

// Opacity of a sample whose voxel length has `depth` halvings of the light, and that stands for `exponent` (16.16) of them.
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

// over() on the wide words, and the packet's after them.
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

// The segmentation LUT's opacities as halvings of the light in one voxel length; kOpaqueDepth: nothing passes.
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

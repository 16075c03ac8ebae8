// Front-to-back compositing by the over operator [P §2.1; Porter and Duff 1984] in the words of the ray [H407-H409].
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "datapath/fixed.h"
#include "datapath/shade.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

// Adds a sample of corrected opacity `alpha` (24 bits) behind the ray's accumulated values: its `colour` is
// premultiplied, 4095 = one, its `opacity` 2^24 - 1 = one.
template <typename Ray>
constexpr void over(Ray& ray, const Colour12& colour, std::uint32_t alpha) {
  const std::uint64_t weight = divide_by_full_scale<24>(std::uint64_t{wire::kOpacityOne - ray.opacity} * alpha);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto added =
        static_cast<std::uint32_t>(divide_by_full_scale<24>(static_cast<std::uint64_t>(colour[c]) * weight));
    // Rounding may make the sum exceed one by a unit.
    ray.colour[c] = static_cast<std::uint16_t>(std::min(ray.colour[c] + added, wire::kColourOne));
  }
  ray.opacity += static_cast<std::uint32_t>(weight);
}

// The fraction that the ray can still add to the image, 12 bits.
constexpr std::uint16_t contribution(std::uint32_t opacity) {
  return static_cast<std::uint16_t>((wire::kOpacityOne - opacity) >> 12);
}

}  // namespace gicube::emu

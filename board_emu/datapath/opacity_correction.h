// Opacity correction, alpha' = 1 - (1 - alpha)^e for a sample that represents e voxel lengths [P §2.1], by two small
// tables like a power unit in hardware: log2 of the transparency and 2^-x, each with 1024 linear segments [H410].
//
// Full-scale alpha stays exactly one (1 - (1-alpha)^e has an infinite slope there for e < 1), and a zero alpha zero.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gicube/wire/lut.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

class OpacityCorrection {
 public:
  // `alpha`: 16 bits, per voxel length. `exponent`: 16.16 voxel lengths. The result has 24 bits.
  std::uint32_t operator()(std::uint16_t alpha, std::uint32_t exponent) const {
    if (alpha == wire::kClassifiedOpacityOne) return wire::kOpacityOne;
    const std::uint64_t x = (std::uint64_t{depth(alpha)} * exponent + (1u << 15)) >> 16;  // 40.24
    return wire::kOpacityOne - exp2_negative(x);
  }

  static constexpr int kSegmentBits = 10;
  static constexpr std::size_t kSegments = std::size_t{1} << kSegmentBits;
  static constexpr int kFractionBits = 24;

  // -log2(1 - alpha), 8.24, for an alpha below full scale; 0 only for alpha 0.
  std::uint32_t depth(std::uint16_t alpha) const {
    return static_cast<std::uint32_t>(full_scale_log2_) - log2(wire::kClassifiedOpacityOne - alpha);
  }
  // 2^-(segment / kSegments) in 24 bits.
  std::uint32_t exp2_at(std::size_t segment) const { return exp2_[segment]; }

  OpacityCorrection() {
    for (std::size_t i = 0; i <= kSegments; ++i) {
      const double t = static_cast<double>(i) / kSegments;
      log2_[i] = static_cast<std::uint32_t>(std::lround(std::log2(1 + t) * kOne));
      exp2_[i] = static_cast<std::uint32_t>(std::lround(std::exp2(-t) * wire::kOpacityOne));
    }
    full_scale_log2_ = log2(wire::kClassifiedOpacityOne);
  }

 private:
  static constexpr double kOne = 1 << kFractionBits;

  // Base-2 logarithm of 1..65535 with 24 fraction bits.
  std::uint32_t log2(std::uint32_t transparency) const {
    const int exponent = std::bit_width(transparency) - 1;
    const std::uint32_t mantissa = (transparency << (16 - exponent)) & 0xFFFFu;  // below the leading one, 0.16
    const std::size_t segment = mantissa >> (16 - kSegmentBits);
    const std::uint32_t t = mantissa & ((1u << (16 - kSegmentBits)) - 1);
    const std::uint32_t rise = log2_[segment + 1] - log2_[segment];
    return (static_cast<std::uint32_t>(exponent) << kFractionBits) + log2_[segment] +
           ((rise * t + (1u << (15 - kSegmentBits))) >> (16 - kSegmentBits));
  }

  // 2^-x, x with 24 fraction bits, in 24 bits with 2^24 - 1 = one.
  std::uint32_t exp2_negative(std::uint64_t x) const {
    const std::uint64_t whole = x >> kFractionBits;
    if (whole > kFractionBits) return 0;
    const auto fraction = static_cast<std::uint32_t>(x & ((1u << kFractionBits) - 1));
    const std::size_t segment = fraction >> (kFractionBits - kSegmentBits);
    const std::uint64_t t = fraction & ((1u << (kFractionBits - kSegmentBits)) - 1);
    const std::uint64_t fall = exp2_[segment] - exp2_[segment + 1];
    const std::uint64_t value = (std::uint64_t{exp2_[segment]} << (kFractionBits - kSegmentBits)) - fall * t;
    const std::uint64_t shift = whole + kFractionBits - kSegmentBits;
    return static_cast<std::uint32_t>((value + (std::uint64_t{1} << (shift - 1))) >> shift);
  }

  std::array<std::uint32_t, kSegments + 1> log2_{};
  std::array<std::uint32_t, kSegments + 1> exp2_{};
  std::uint64_t full_scale_log2_ = 0;
};

}  // namespace gicube::emu

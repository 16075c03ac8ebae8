// Trilinear resampling of density and gradient: seven linear interpolators a channel [P §3.4].
//
// What enters: the eight decoded voxels round a sample and the sample's fractions; what leaves: one word a channel.
// Interpolator words have 16 bits (words.h), weights are 0.15.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

inline constexpr int kWeightBits = 15;

// a + round((b - a) w), w in 0.15.
constexpr std::int16_t lerp(std::int16_t a, std::int16_t b, int w) {
  return static_cast<std::int16_t>(a + (((b - a) * w + (1 << (kWeightBits - 1))) >> kWeightBits));
}

// A position's fraction (14 bits) as a weight.
constexpr int weight(std::uint32_t fraction) {
  return static_cast<int>(fraction) << (kWeightBits - wire::kPositionFractionBits);
}

// The eight voxels round a sample: `cell` points at the one of least coordinates, rows and slices of its block are `row`
// and `slice` voxels apart; the weights are the sample's place between them.
struct Neighbourhood {
  const DecodedVoxel* cell;
  std::size_t row;
  std::size_t slice;
  std::array<int, 3> weight;
};

// All channels of a sample: density, gradient x y z.
using Channels = std::array<std::int16_t, 4>;

// One channel: 0 density, 1..3 gradient. Channels are apart because a sample of no opacity needs no gradient.
constexpr std::int16_t resample(const Neighbourhood& at, std::size_t channel) {
  const auto along_x = [&at, channel](std::size_t voxel) {
    return lerp(at.cell[voxel].channel[channel], at.cell[voxel + 1].channel[channel], at.weight[0]);
  };
  const std::int16_t near = lerp(along_x(0), along_x(at.row), at.weight[1]);
  const std::int16_t far = lerp(along_x(at.slice), along_x(at.slice + at.row), at.weight[1]);
  return lerp(near, far, at.weight[2]);
}

// The density where it stands alone.
constexpr std::int16_t resample_density(const std::int16_t* cell, std::size_t row, std::size_t slice,
                                        const std::array<int, 3>& weight) {
  const auto along_x = [&](std::size_t i) { return lerp(cell[i], cell[i + 1], weight[0]); };
  const std::int16_t near = lerp(along_x(0), along_x(row), weight[1]);
  const std::int16_t far = lerp(along_x(slice), along_x(slice + row), weight[1]);
  return lerp(near, far, weight[2]);
}

// The same, channel by channel.
constexpr Channels resample_each(const Neighbourhood& at) {
  return {resample(at, 0), resample(at, 1), resample(at, 2), resample(at, 3)};
}

#if defined(__SSE2__)
// lerp() in eight lanes: round((b - a) w / 2^15) from the product's high and low halves.
inline __m128i lerp(__m128i a, __m128i b, __m128i w) {
  const __m128i difference = _mm_sub_epi16(b, a);  // fits 16 bits (words.h)
  const __m128i high = _mm_mulhi_epi16(difference, w), low = _mm_mullo_epi16(difference, w);
  // Bits 15 and 14 of the low half are the quotient's last bit and the one that rounds.
  const __m128i last = _mm_srli_epi16(_mm_add_epi16(_mm_srli_epi16(low, 14), _mm_set1_epi16(1)), 1);
  return _mm_add_epi16(a, _mm_add_epi16(_mm_add_epi16(high, high), last));
}
#endif

// All four at once: the two voxels of a row are one load, the channels are lanes, so seven interpolators a channel are four
// instructions' worth of lerps.
inline Channels resample_all(const Neighbourhood& at) {
#if defined(__SSE2__)
  const auto row = [&at](std::size_t voxel) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at.cell + voxel));
  };
  const auto weight = [&at](std::size_t axis) { return _mm_set1_epi16(static_cast<std::int16_t>(at.weight[axis])); };
  const __m128i r00 = row(0), r01 = row(at.row), r10 = row(at.slice), r11 = row(at.slice + at.row);
  const __m128i wx = weight(0), wy = weight(1), wz = weight(2);
  const __m128i near = lerp(_mm_unpacklo_epi64(r00, r01), _mm_unpackhi_epi64(r00, r01), wx);
  const __m128i far = lerp(_mm_unpacklo_epi64(r10, r11), _mm_unpackhi_epi64(r10, r11), wx);
  const __m128i slices = lerp(_mm_unpacklo_epi64(near, far), _mm_unpackhi_epi64(near, far), wy);
  const __m128i sample = lerp(slices, _mm_unpackhi_epi64(slices, slices), wz);
  Channels channels;
  _mm_storel_epi64(reinterpret_cast<__m128i*>(channels.data()), sample);
  return channels;
#else
  return resample_each(at);
#endif
}

// The least and the greatest density round a sample, 12.3.
struct DensityRange {
  std::int16_t least, greatest;
};
// Voxel by voxel.
constexpr DensityRange density_range_each(const Neighbourhood& at) {
  DensityRange out{at.cell->channel[0], at.cell->channel[0]};
  for (const std::size_t corner : {std::size_t{0}, at.row, at.slice, at.slice + at.row}) {
    for (const std::size_t voxel : {corner, corner + 1}) {
      out.least = std::min(out.least, at.cell[voxel].channel[0]);
      out.greatest = std::max(out.greatest, at.cell[voxel].channel[0]);
    }
  }
  return out;
}
// All at once.
inline DensityRange density_range(const Neighbourhood& at) {
#if defined(__SSE2__)
  const auto row = [&at](std::size_t voxel) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at.cell + voxel));
  };
  const __m128i r00 = row(0), r01 = row(at.row), r10 = row(at.slice), r11 = row(at.slice + at.row);
  const __m128i low = _mm_min_epi16(_mm_min_epi16(r00, r01), _mm_min_epi16(r10, r11));
  const __m128i high = _mm_max_epi16(_mm_max_epi16(r00, r01), _mm_max_epi16(r10, r11));
  const auto first = [](__m128i words) { return static_cast<std::int16_t>(_mm_cvtsi128_si32(words)); };
  return {first(_mm_min_epi16(low, _mm_srli_si128(low, 8))), first(_mm_max_epi16(high, _mm_srli_si128(high, 8)))};
#else
  return density_range_each(at);
#endif
}

}  // namespace gicube::emu

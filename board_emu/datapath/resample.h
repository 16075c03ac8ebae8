// Trilinear resampling of density and gradient, and classification by density: seven linear interpolators per channel
// [P §3.4].
//
// Input: the words of the eight voxels around the sample, and the sample's fractions. Output: one word per channel.
// Interpolator words have 16 bits (words.h), weights are 0.15. Density and gradient are separate, because a transparent
// sample needs no gradient [H403-H406, H804].
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "gicube/wire/lut.h"
#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

inline constexpr int kWeightBits = 15;

// a + round((b - a) w), w in 0.15.
constexpr std::int16_t lerp(std::int16_t a, std::int16_t b, int w) {
  return static_cast<std::int16_t>(a + (((b - a) * w + (1 << (kWeightBits - 1))) >> kWeightBits));
}

// Converts a position's fraction (14 bits) to a weight.
constexpr int weight(std::uint32_t fraction) {
  return static_cast<int>(fraction) << (kWeightBits - wire::kPositionFractionBits);
}

// Position of a sample: `first` is the voxel of least coordinates around it, `row` and `slice` are the distances of
// rows and slices of its block in voxels, `weight` is the sample's position between them.
struct Neighbourhood {
  std::size_t first;
  std::size_t row;
  std::size_t slice;
  std::array<int, 3> weight;
};

// All channels of a sample.
using Channels = std::array<std::int16_t, 4>;

// Interpolates one word per voxel, `word(i)`.
template <typename Word>
constexpr std::int16_t resample_words(const Neighbourhood& at, const Word& word) {
  const auto along_x = [&](std::size_t i) { return lerp(word(i), word(i + 1), at.weight[0]); };
  const std::size_t first = at.first, down = first + at.row, deep = first + at.slice;
  const std::int16_t near = lerp(along_x(first), along_x(down), at.weight[1]);
  const std::int16_t far = lerp(along_x(deep), along_x(deep + at.row), at.weight[1]);
  return lerp(near, far, at.weight[2]);
}

constexpr std::int16_t resample_density(const std::int16_t* densities, const Neighbourhood& at) {
  return resample_words(at, [densities](std::size_t i) { return densities[i]; });
}

// Interpolates four channels one after the other; `words(i)`: the words of a voxel.
template <typename Words>
constexpr Channels resample_each(const Neighbourhood& at, const Words& words) {
  Channels out{};
  for (std::size_t c = 0; c < out.size(); ++c) {
    out[c] = resample_words(at, [&words, c](std::size_t i) { return words(i).channel[c]; });
  }
  return out;
}

#if defined(__SSE2__)
// lerp() in eight lanes: round((b - a) w / 2^15) from the product's high and low halves.
inline __m128i lerp(__m128i a, __m128i b, __m128i w) {
  const __m128i difference = _mm_sub_epi16(b, a);  // fits 16 bits (words.h)
  const __m128i high = _mm_mulhi_epi16(difference, w), low = _mm_mullo_epi16(difference, w);
  // Bits 15 and 14 of the low half are the quotient's last bit and its rounding bit.
  const __m128i last = _mm_srli_epi16(_mm_add_epi16(_mm_srli_epi16(low, 14), _mm_set1_epi16(1)), 1);
  return _mm_add_epi16(a, _mm_add_epi16(_mm_add_epi16(high, high), last));
}
#endif

// Interpolates four channels at once: the two voxels of a row are one vector, channels are lanes, so seven
// interpolators per channel take four vector lerps. `words(i)`: a reference to the words of a voxel.
template <typename Words>
inline Channels resample_all(const Neighbourhood& at, const Words& words) {
#if defined(__SSE2__)
  const auto row = [&](std::size_t voxel) {
    const auto half = [&](std::size_t i) { return reinterpret_cast<const __m128i*>(&words(i)); };
    return _mm_unpacklo_epi64(_mm_loadl_epi64(half(voxel)), _mm_loadl_epi64(half(voxel + 1)));
  };
  const auto weight = [&at](std::size_t axis) { return _mm_set1_epi16(static_cast<std::int16_t>(at.weight[axis])); };
  const __m128i r00 = row(at.first), r01 = row(at.first + at.row);
  const __m128i r10 = row(at.first + at.slice), r11 = row(at.first + at.slice + at.row);
  const __m128i wx = weight(0), wy = weight(1), wz = weight(2);
  const __m128i near = lerp(_mm_unpacklo_epi64(r00, r01), _mm_unpackhi_epi64(r00, r01), wx);
  const __m128i far = lerp(_mm_unpacklo_epi64(r10, r11), _mm_unpackhi_epi64(r10, r11), wx);
  const __m128i slices = lerp(_mm_unpacklo_epi64(near, far), _mm_unpackhi_epi64(near, far), wy);
  const __m128i sample = lerp(slices, _mm_unpackhi_epi64(slices, slices), wz);
  Channels channels;
  _mm_storel_epi64(reinterpret_cast<__m128i*>(channels.data()), sample);
  return channels;
#else
  return resample_each(at, words);
#endif
}

// The least and the greatest density around a sample, 12.3.
struct DensityRange {
  std::int16_t least, greatest;
};
// Computed voxel by voxel.
constexpr DensityRange density_range_each(const std::int16_t* densities, const Neighbourhood& at) {
  DensityRange out{densities[at.first], densities[at.first]};
  for (const std::size_t corner : {std::size_t{0}, at.row, at.slice, at.slice + at.row}) {
    for (const std::size_t voxel : {at.first + corner, at.first + corner + 1}) {
      out.least = std::min(out.least, densities[voxel]);
      out.greatest = std::max(out.greatest, densities[voxel]);
    }
  }
  return out;
}
// Computed with vectors.
inline DensityRange density_range(const std::int16_t* densities, const Neighbourhood& at) {
#if defined(__SSE2__)
  const auto pair = [&](std::size_t voxel) {
    std::int32_t both = 0;
    std::memcpy(&both, densities + at.first + voxel, sizeof both);
    return _mm_cvtsi32_si128(both);
  };
  const __m128i near = _mm_unpacklo_epi32(pair(0), pair(at.row));
  const __m128i far = _mm_unpacklo_epi32(pair(at.slice), pair(at.slice + at.row));
  __m128i low = _mm_min_epi16(near, far), high = _mm_max_epi16(near, far);  // four in the lower half
  low = _mm_min_epi16(low, _mm_srli_epi64(low, 32));
  high = _mm_max_epi16(high, _mm_srli_epi64(high, 32));
  const auto first = [](__m128i words) { return static_cast<std::int16_t>(_mm_cvtsi128_si32(words)); };
  return {first(_mm_min_epi16(low, _mm_srli_epi64(low, 16))), first(_mm_max_epi16(high, _mm_srli_epi64(high, 16)))};
#else
  return density_range_each(densities, at);
#endif
}

// Classification: the segmentation LUT's index of an interpolated density (12.3), rounded to 12 bits, of material
// `tag`.
constexpr std::size_t segmentation_index(int density, unsigned tag) {
  const int rounded = (density + (1 << (kDensityFractionBits - 1))) >> kDensityFractionBits;
  return std::size_t{tag} << 12 | static_cast<std::size_t>(rounded);
}

}  // namespace gicube::emu

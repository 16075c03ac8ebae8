// Points that fill the unit hypercube evenly: Sobol's sequence (direction numbers of Joe and Kuo 2008), each coordinate
// scrambled by nested uniform scrambling [Owen 1995; P §2.2 says "a quasi-random scheme"].
//
// Every seed is an independent scramble; with each of them any first 2^m points lie as evenly as before the scrambling,
// and each point by itself is uniform. Coordinates are pure functions of (index, dimension, seed).
#pragma once

#include <cstdint>

#include "words/mix64.h"

namespace gicube::emu {

inline constexpr std::uint32_t kSobolDimensions = 4;
inline constexpr std::uint32_t kSobolBits =
    12;  // chosen: sequences of up to 4096 points, the most rays of a face voxel
inline constexpr std::uint32_t kSobolPoints = 1u << kSobolBits;

// Mixes two words into 64 bits that look random (SplitMix64; Steele, Lea, Flood 2014).
constexpr std::uint64_t hash(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15u;
  return mix64((mix64(a + kStep) ^ b) + kStep);
}

// A hash as a number in [0, 1).
constexpr double to_unit(std::uint64_t hashed) { return static_cast<double>(hashed >> 11) * 0x1p-53; }

// Coordinate `dimension` of point `index` (< kSobolPoints) of Sobol's sequence itself, as a fraction of 2^kSobolBits.
std::uint32_t sobol(std::uint32_t index, std::uint32_t dimension);

// The same, scrambled, in [0, 1). Dimensions 0 and 1 together are a (0,2)-sequence in base 2.
double scrambled_sobol(std::uint32_t index, std::uint32_t dimension, std::uint64_t seed);

}  // namespace gicube::emu

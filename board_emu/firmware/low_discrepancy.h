// Points that fill the unit hypercube evenly: Sobol' sequence (direction numbers of Joe and Kuo 2008), each coordinate
// scrambled by nested uniform scrambling [Owen 1995; P §2.2 says "a quasi-random scheme"].
//
// Each seed gives an independent scrambling. For every seed, the first 2^m points are as evenly distributed as without
// it, and each single point is uniform. Coordinates are pure functions of (index, dimension, seed).
#pragma once

#include <cstdint>

#include "gicube/wire/mix64.h"

namespace gicube::emu {

inline constexpr std::uint32_t kSobolDimensions = 4;
inline constexpr std::uint32_t kSobolBits = 12;  // chosen: up to 4096 points, the maximum number of rays per face voxel
inline constexpr std::uint32_t kSobolPoints = 1u << kSobolBits;

// Mixes two words into 64 pseudo-random bits.
constexpr std::uint64_t hash(std::uint64_t a, std::uint64_t b) { return wire::split_mix64(wire::split_mix64(a) ^ b); }

// A hash as a number in [0, 1).
constexpr double to_unit(std::uint64_t hashed) { return static_cast<double>(hashed >> 11) * 0x1p-53; }

// Coordinate `dimension` of point `index` (< kSobolPoints) of the plain Sobol' sequence, as a fraction of 2^kSobolBits.
std::uint32_t sobol(std::uint32_t index, std::uint32_t dimension);

// The scrambled coordinate, in [0, 1). Dimensions 0 and 1 together are a (0,2)-sequence in base 2.
double scrambled_sobol(std::uint32_t index, std::uint32_t dimension, std::uint64_t seed);

}  // namespace gicube::emu

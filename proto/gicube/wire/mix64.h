// SplitMix64's hash [Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014].
#pragma once

#include <cstdint>

namespace gicube::wire {

// The finalizer alone: mixes 64 bits with full avalanche; 0 stays 0.
constexpr std::uint64_t mix64(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
  x = (x ^ x >> 27) * 0x94D049BB133111EBu;
  return x ^ x >> 31;
}

// The generator's number for state `x`.
constexpr std::uint64_t split_mix64(std::uint64_t x) { return mix64(x + 0x9E3779B97F4A7C15u); }

}  // namespace gicube::wire

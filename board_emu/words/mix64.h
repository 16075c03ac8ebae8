// The board's mixing hash.
#pragma once

#include <cstdint>

namespace gicube::emu {

// A full-avalanche mix of 64 bits (the finalizer of SplitMix64; Steele, Lea, Flood 2014).
constexpr std::uint64_t mix64(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xBF58476D1CE4E5B9u;
  x ^= x >> 27;
  x *= 0x94D049BB133111EBu;
  return x ^ x >> 31;
}

}  // namespace gicube::emu

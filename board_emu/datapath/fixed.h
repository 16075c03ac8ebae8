// Rounds products of the pipeline's fixed-point words.
#pragma once

#include <cstdint>

namespace gicube::emu {

// a * b / (2^Bits - 1), rounded to nearest, for a word b whose full scale 2^Bits - 1 represents one. Exact: full scale
// times x is x. `product` < 2^(2 Bits).
template <int Bits>
constexpr std::uint64_t divide_by_full_scale(std::uint64_t product) {
  const std::uint64_t t = product + (std::uint64_t{1} << (Bits - 1));
  return (t + (t >> Bits)) >> Bits;
}

// Removes `Bits` fraction bits of a signed product, rounding half up.
template <int Bits>
constexpr std::int64_t round_shift(std::int64_t value) {
  return (value + (std::int64_t{1} << (Bits - 1))) >> Bits;
}

}  // namespace gicube::emu

// Sobol' sequence. It fills the unit hypercube evenly: the first 2^m points do, and so do any 2^m that begin at a
// multiple of 2^m.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace gicube::wire {

inline constexpr std::uint32_t kSobolDimensions = 6;

// Direction numbers by dimension and bit of the index [Joe and Kuo, "Constructing Sobol sequences with better
// two-dimensional projections", SIAM J. Sci. Comput. 2008].
inline constexpr auto kSobolDirections = [] {
  // A primitive polynomial x^degree + ... + 1 over GF(2): `inner` holds the coefficients between the first and the
  // last, `first` the odd initial numbers.
  struct Polynomial {
    std::uint32_t degree, inner;
    std::array<std::uint32_t, 4> first;
  };
  constexpr std::array<Polynomial, kSobolDimensions - 1> kPolynomials{
      {{1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}, {3, 2, {1, 1, 1}}, {4, 1, {1, 1, 3, 3}}}};
  std::array<std::array<std::uint32_t, 32>, kSobolDimensions> directions{};
  for (std::uint32_t i = 0; i < 32; ++i) directions[0][i] = 1u << (31 - i);  // van der Corput sequence
  for (std::uint32_t d = 1; d < kSobolDimensions; ++d) {
    const auto& [degree, inner, first] = kPolynomials[d - 1];
    auto& v = directions[d];
    for (std::uint32_t i = 0; i < 32; ++i) {
      if (i < degree) {
        v[i] = first[i] << (31 - i);
        continue;
      }
      v[i] = v[i - degree] ^ v[i - degree] >> degree;
      for (std::uint32_t j = 1; j < degree; ++j) {
        if (inner >> (degree - 1 - j) & 1u) v[i] ^= v[i - j];
      }
    }
  }
  return directions;
}();

// Coordinate `dimension` of point `index`, as a fraction of 2^32.
constexpr std::uint32_t sobol(std::uint32_t index, std::uint32_t dimension) {
  std::uint32_t x = 0;
  for (; index != 0; index &= index - 1) {
    x ^= kSobolDirections[dimension][static_cast<std::size_t>(std::countr_zero(index))];
  }
  return x;
}

}  // namespace gicube::wire

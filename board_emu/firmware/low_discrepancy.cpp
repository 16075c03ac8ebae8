#include "firmware/low_discrepancy.h"

#include <array>

namespace gicube::emu {

namespace {

using Directions = std::array<std::uint32_t, kSobolBits>;

// Direction numbers of a primitive polynomial x^degree + ... + 1 over GF(2). `inner` holds the coefficients between the
// first and the last, `first` the odd initial numbers m_1 ... m_degree.
constexpr Directions directions(std::uint32_t degree, std::uint32_t inner, const std::array<std::uint32_t, 3>& first) {
  Directions v{};
  for (std::uint32_t i = 0; i < kSobolBits; ++i) {
    if (i < degree) {
      v[i] = first[i] << (kSobolBits - 1 - i);
      continue;
    }
    v[i] = v[i - degree] ^ v[i - degree] >> degree;
    for (std::uint32_t j = 1; j < degree; ++j) {
      if (inner >> (degree - 1 - j) & 1u) v[i] ^= v[i - j];
    }
  }
  return v;
}

constexpr Directions van_der_corput() {
  Directions v{};
  for (std::uint32_t i = 0; i < kSobolBits; ++i) v[i] = 1u << (kSobolBits - 1 - i);
  return v;
}

constexpr std::array<Directions, kSobolDimensions> kDirections{van_der_corput(), directions(1, 0, {1}),
                                                               directions(2, 1, {1, 3}), directions(3, 1, {1, 3, 1})};

// Whether a bit of a coordinate is flipped depends on a random bit selected by the more significant bits. One hash
// provides the random bits for six bits: the nodes of a binary tree of that depth, numbered level by level.
constexpr std::uint32_t kTreeDepth = 6;
static_assert(kSobolBits == 2 * kTreeDepth);

constexpr std::uint32_t scramble_tree(std::uint32_t bits, std::uint64_t coins) {
  std::uint32_t scrambled = 0;
  for (std::uint32_t depth = 0; depth < kTreeDepth; ++depth) {
    const std::uint32_t before = bits >> (kTreeDepth - depth);
    const std::uint32_t coin = static_cast<std::uint32_t>(coins >> ((1u << depth) - 1 + before)) & 1u;
    scrambled = scrambled << 1 | ((bits >> (kTreeDepth - 1 - depth) & 1u) ^ coin);
  }
  return scrambled;
}

}  // namespace

std::uint32_t sobol(std::uint32_t index, std::uint32_t dimension) {
  std::uint32_t x = 0;
  for (std::uint32_t i = 0; i < kSobolBits; ++i) {
    if (index >> i & 1u) x ^= kDirections[dimension][i];
  }
  return x;
}

double scrambled_sobol(std::uint32_t index, std::uint32_t dimension, std::uint64_t seed) {
  const std::uint32_t x = sobol(index, dimension);
  const std::uint32_t high = x >> kTreeDepth, low = x & ((1u << kTreeDepth) - 1);
  const std::uint64_t key = hash(seed, dimension);
  const std::uint32_t scrambled =
      scramble_tree(high, hash(key, 0)) << kTreeDepth | scramble_tree(low, hash(key, 1 + high));
  // No two points share all bits so far, so the remaining bits are one uniform number each.
  const double rest = to_unit(hash(key, (std::uint64_t{1} << 32) + x));
  // There are 52 bits in total, so the sum is exact and stays below 1.
  const double fine = static_cast<double>(static_cast<std::uint64_t>(rest * 0x1p40)) * 0x1p-40;
  return (scrambled + fine) / kSobolPoints;
}

}  // namespace gicube::emu

// The scrambled points keep the evenness of the plain ones, and are independent between seeds.
#include "firmware/low_discrepancy.h"

#include <bitset>

#include "test.h"

namespace gicube::emu {
namespace {

TEST(Sobol, BeginsAsPublished) {
  // The first eight points with the direction numbers of Joe and Kuo, which are listed in the order of the Gray code.
  constexpr std::array<std::array<double, kSobolDimensions>, 8> kPublished{{{0, 0, 0, 0},
                                                                            {.5, .5, .5, .5},
                                                                            {.75, .25, .25, .25},
                                                                            {.25, .75, .75, .75},
                                                                            {.375, .375, .625, .875},
                                                                            {.875, .875, .125, .375},
                                                                            {.625, .125, .875, .625},
                                                                            {.125, .625, .375, .125}}};
  for (std::uint32_t i = 0; i < kPublished.size(); ++i) {
    for (std::uint32_t dimension = 0; dimension < kSobolDimensions; ++dimension)
      EXPECT_EQ(sobol(i ^ i >> 1, dimension), kPublished[i][dimension] * kSobolPoints) << i << " " << dimension;
  }
}

TEST(ScrambledSobol, PutsOnePointInEachElementaryIntervalOfTheUnitSquare) {
  for (const std::uint64_t seed : {1u, 2u, 77u}) {
    for (int m = 0; m <= 10; ++m) {
      for (int wide = 0; wide <= m; ++wide) {  // 2^wide columns, 2^(m - wide) rows
        std::set<std::pair<int, int>> hit;
        for (std::uint32_t i = 0; i < 1u << m; ++i) {
          hit.emplace(static_cast<int>(std::ldexp(scrambled_sobol(i, 0, seed), wide)),
                      static_cast<int>(std::ldexp(scrambled_sobol(i, 1, seed), m - wide)));
        }
        ASSERT_EQ(hit.size(), std::size_t{1} << m) << "seed " << seed << " m " << m << " columns 2^" << wide;
      }
    }
  }
}

TEST(ScrambledSobol, PutsOnePointInEachIntervalOfEveryDimension) {
  for (std::uint32_t dimension = 0; dimension < kSobolDimensions; ++dimension) {
    std::set<int> hit;
    for (std::uint32_t i = 0; i < kSobolPoints; ++i)
      hit.insert(static_cast<int>(scrambled_sobol(i, dimension, 5) * kSobolPoints));
    EXPECT_EQ(hit.size(), kSobolPoints) << dimension;
  }
}

TEST(ScrambledSobol, StaysBelowOne) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    for (std::uint32_t i = 0; i < 64; ++i) {
      ASSERT_GE(scrambled_sobol(i, 0, seed), 0);
      ASSERT_LT(scrambled_sobol(i, 0, seed), 1);
    }
  }
}

// Mean of x y - 1/4 over seeds: 0 for independent uniform numbers, each product's deviation is sqrt(7)/12.
double covariance_error(const auto& x, const auto& y) {
  constexpr int kSeeds = 40'000;
  double sum = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) sum += x(seed) * y(seed) - 0.25;
  return sum / kSeeds / (std::sqrt(7.0 / 144) / std::sqrt(kSeeds));
}

TEST(ScrambledSobol, IsUncorrelatedBetweenSeedsAndDimensions) {
  const auto at = [](std::uint32_t i, std::uint32_t dimension, std::uint64_t offset) {
    return [=](std::uint64_t seed) { return scrambled_sobol(i, dimension, seed * 2 + offset); };
  };
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_LT(std::abs(covariance_error(at(i, 0, 0), at(i, 0, 1))), 4) << "neighbouring seeds, point " << i;
    EXPECT_LT(std::abs(covariance_error(at(i, 0, 0), at(i, 1, 0))), 4) << "dimensions 0 and 1, point " << i;
    EXPECT_LT(std::abs(covariance_error(at(i, 2, 0), at(i, 3, 0))), 4) << "dimensions 2 and 3, point " << i;
  }
}

// Nested uniform scrambling: whether a bit is flipped is a coin of its own for each value of the bits before it. Tried
// for the high six bits, and for the low six between 1/64 and 2/64.
TEST(ScrambledSobol, FlipsEachBitByACoinOfItsOwn) {
  constexpr std::size_t kSeeds = 256, kNodes = 63;
  std::vector<std::bitset<kSeeds>> coins(2 * kNodes);
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto toss = [&](std::uint32_t index, int shift, std::size_t first_node) {
      const auto scrambled = static_cast<std::uint32_t>(scrambled_sobol(index, 0, seed) * kSobolPoints);
      const std::uint32_t plain = sobol(index, 0), flipped = scrambled ^ plain, bits = plain >> shift & 63u;
      for (std::uint32_t depth = 0; depth < 6; ++depth) {
        const std::size_t node = first_node + (1u << depth) - 1 + (bits >> (6 - depth));
        coins[node][seed] = (flipped >> shift >> (5 - depth) & 1u) != 0;
      }
    };
    // Dimension 0 mirrors the index's twelve bits: the low six are the coarse ones.
    for (std::uint32_t i = 0; i < 64; ++i) {
      toss(i, 6, 0);
      toss(32 | i << 6, 0, kNodes);
    }
  }
  for (std::size_t a = 0; a < coins.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const auto differ = static_cast<double>((coins[a] ^ coins[b]).count());
      ASSERT_NEAR(differ, kSeeds / 2.0, 5.5 * std::sqrt(kSeeds / 4.0)) << a << ' ' << b;
    }
  }
}

TEST(ScrambledSobol, IntegratesBetterThanRandomPoints) {
  double squared = 0;
  constexpr int kSeeds = 200;
  constexpr std::uint32_t kPoints = 256;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    double sum = 0;
    for (std::uint32_t i = 0; i < kPoints; ++i)
      sum += scrambled_sobol(i, 0, seed) * scrambled_sobol(i, 1, seed) * scrambled_sobol(i, 2, seed) *
             scrambled_sobol(i, 3, seed);
    squared += std::pow(sum / kPoints - 1.0 / 16, 2);
  }
  const double variance_of_random = (1.0 / 81 - 1.0 / 256) / kPoints;
  EXPECT_LT(squared / kSeeds, variance_of_random / 10);
}

}  // namespace
}  // namespace gicube::emu

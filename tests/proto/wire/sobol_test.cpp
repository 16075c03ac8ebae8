#include "gicube/wire/sobol.h"

#include "test.h"

namespace gicube::wire {
namespace {

TEST(Sobol, BeginsAsPublished) {
  // The first eight points with the direction numbers of Joe and Kuo, which are listed in the order of the Gray code.
  constexpr std::array<std::array<double, kSobolDimensions>, 8> kPublished{{{0, 0, 0, 0, 0, 0},
                                                                            {.5, .5, .5, .5, .5, .5},
                                                                            {.75, .25, .25, .25, .75, .75},
                                                                            {.25, .75, .75, .75, .25, .25},
                                                                            {.375, .375, .625, .875, .375, .125},
                                                                            {.875, .875, .125, .375, .875, .625},
                                                                            {.625, .125, .875, .625, .625, .875},
                                                                            {.125, .625, .375, .125, .125, .375}}};
  for (std::uint32_t i = 0; i < kPublished.size(); ++i) {
    for (std::uint32_t d = 0; d < kSobolDimensions; ++d)
      EXPECT_EQ(sobol(i ^ i >> 1, d) * 0x1p-32, kPublished[i][d]) << i << " " << d;
  }
}

// m_k = 2 a_1 m_(k-1) + 4 a_2 m_(k-2) + ... + 2^s m_(k-s) + m_(k-s), sums without carries.
TEST(Sobol, GoesOnByThePublishedRecurrence) {
  struct Row {
    std::vector<std::uint64_t> a, m;
  };
  const std::array<Row, 5> rows{
      {{{}, {1}}, {{1}, {1, 3}}, {{0, 1}, {1, 3, 1}}, {{1, 0}, {1, 1, 1}}, {{0, 0, 1}, {1, 1, 3, 3}}}};
  for (std::uint32_t d = 1; d < kSobolDimensions; ++d) {
    auto [a, m] = rows[d - 1];
    const std::size_t s = m.size();
    for (std::size_t k = s; k < 32; ++k) {
      std::uint64_t next = m[k - s] << s ^ m[k - s];
      for (std::size_t j = 1; j < s; ++j) next ^= a[j - 1] * m[k - j] << j;
      m.push_back(next);
    }
    for (std::uint32_t k = 0; k < 32; ++k) EXPECT_EQ(sobol(1u << k, d), m[k] << (31 - k)) << d << " " << k;
  }
}

TEST(Sobol, PutsOnePointInEachIntervalOfEveryDimension) {
  for (std::uint32_t d = 0; d < kSobolDimensions; ++d) {
    std::set<std::uint32_t> hit;
    for (std::uint32_t i = 0; i < 4096; ++i) hit.insert(sobol(3 * 4096 + i, d) >> 20);
    EXPECT_EQ(hit.size(), 4096u) << d;
  }
}

}  // namespace
}  // namespace gicube::wire

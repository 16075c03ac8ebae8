#include "cone_beam/phantom/phantom.h"

#include "gicube/error.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr int kSide = 64;

Projections even(float value, int views = 8) {
  Projections out{kSide, kSide, {}};
  out.values.assign(out.view_size() * static_cast<std::size_t>(views), value);
  return out;
}

struct Moments {
  double mean = 0, variance = 0;
};
Moments counts_of(const Projections& projections, double photons) {
  double sum = 0, squares = 0;
  for (const float value : projections.values) {
    const double count = std::round(photons * std::exp(-double{value}));
    sum += count;
    squares += count * count;
  }
  const auto n = static_cast<double>(projections.values.size());
  return {sum / n, squares / n - sum / n * sum / n};
}

TEST(PoissonNoise, CountsHaveTheMeanAndTheVarianceOfTheirNumber) {
  for (const double photons : {20.0, 200.0, 10'000.0}) {  // of 3, 27 and 1353 that arrive: both ways to draw them
    Projections noisy = even(2);
    const double mean = photons * std::exp(-2);
    EXPECT_EQ(add_poisson_noise(noisy, photons, 1) > 0, photons == 20);
    const Moments found = counts_of(noisy, photons);
    if (photons == 20) continue;  // some pixels are dark there: half a photon each
    const double of_mean = std::sqrt(mean / (8 * kSide * kSide));
    EXPECT_NEAR(found.mean, mean, 4 * of_mean);
    EXPECT_NEAR(found.variance / mean, 1, 4 * std::sqrt(2.0 / (8 * kSide * kSide)));
  }
}

TEST(PoissonNoise, FewPhotonsAreDrawnAsPoissonSaysToo) {
  Projections noisy = even(0);
  const std::size_t dark = add_poisson_noise(noisy, 3, 5);
  const double all = 8 * kSide * kSide, none = all * std::exp(-3);
  EXPECT_NEAR(static_cast<double>(dark), none, 4 * std::sqrt(none));
  for (const float value : noisy.values) ASSERT_TRUE(std::isfinite(value));
  double ones = 0;
  for (const float value : noisy.values) ones += std::abs(double{value} + std::log(1 / 3.0)) < 1e-6;
  EXPECT_NEAR(ones, 3 * none, 4 * std::sqrt(3 * none));
}

TEST(PoissonNoise, TheSameSeedMakesTheSameNoiseAndViewsDiffer) {
  Projections one = even(1), same = even(1), other = even(1);
  add_poisson_noise(one, 500, 7);
  add_poisson_noise(same, 500, 7);
  add_poisson_noise(other, 500, 8);
  EXPECT_EQ(one.values, same.values);
  EXPECT_NE(one.values, other.values);
  EXPECT_FALSE(std::equal(one.view(0), one.view(1), one.view(1)));
}

TEST(PoissonNoise, FirstValuesAreAsEver) {  // on any machine
  Projections noisy{2, 2, {0, 1, 2, 3}};
  add_poisson_noise(noisy, 1000, 42);
  std::vector<double> counts;
  for (const float value : noisy.values) counts.push_back(std::round(1000 * std::exp(-double{value})));
  EXPECT_THAT(counts, ElementsAre(989, 370, 142, 52));
}

TEST(PoissonNoise, PhotonsMustBeSome) {
  Projections none = even(1, 1);
  EXPECT_THROWS(BadArgument, "photons", add_poisson_noise(none, 0, 1));
}

}  // namespace
}  // namespace gicube::samples

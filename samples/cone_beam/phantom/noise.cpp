#include <atomic>
#include <cmath>
#include <random>

#include "cone_beam/phantom/phantom.h"
#include "scene/parallel.h"

namespace gicube::samples {
namespace {

// The standard fixes what this engine gives, but not what its distributions make of it.
using Engine = std::mt19937_64;

double uniform(Engine& engine) { return (static_cast<double>(engine() >> 11) + 0.5) * 0x1p-53; }  // inside 0..1

// Knuth's product of uniform numbers.
double few(Engine& engine, double mean) {
  const double least = std::exp(-mean);
  double product = uniform(engine), count = 0;
  for (; product > least; ++count) product *= uniform(engine);
  return count;
}

// Hoermann (1993), The transformed rejection method for generating Poisson random variables, algorithm PTRS: from mean 10 on.
double many(Engine& engine, double mean) {
  const double b = 0.931 + 2.53 * std::sqrt(mean), a = -0.059 + 0.02483 * b;
  const double inverse_alpha = 1.1239 + 1.1328 / (b - 3.4), quick = 0.9277 - 3.6224 / (b - 2);
  for (;;) {
    const double u = uniform(engine) - 0.5, v = uniform(engine), us = 0.5 - std::abs(u);
    const double k = std::floor((2 * a / us + b) * u + mean + 0.43);
    if (us >= 0.07 && v <= quick) return k;
    if (k < 0 || (us < 0.013 && v > us)) continue;
    const double accepted = k * std::log(mean) - mean - std::lgamma(k + 1);
    if (std::log(v * inverse_alpha / (a / (us * us) + b)) <= accepted) return k;
  }
}

}  // namespace

std::size_t add_poisson_noise(Projections& projections, double photons, std::uint64_t seed) {
  expect(std::isfinite(photons) && photons > 0, "photons", "a finite number above 0", photons);
  const std::size_t size = projections.view_size();
  std::atomic<std::size_t> dark{0};
  in_parallel(projections.values.size() / size, 0, [&](std::size_t view) {
    std::seed_seq sequence{seed & 0xFFFFFFFF, seed >> 32, std::uint64_t{view}};
    Engine engine(sequence);
    std::size_t here = 0;
    for (float* value = projections.view(view); value != projections.view(view) + size; ++value) {
      constexpr double kFew = 10;
      const double mean = photons * std::exp(-static_cast<double>(*value));
      const double count = mean < kFew ? few(engine, mean) : many(engine, mean);
      if (count == 0) ++here;
      *value = static_cast<float>(-std::log((count == 0 ? 0.5 : count) / photons));
    }
    dark += here;
  });
  return dark;
}

}  // namespace gicube::samples

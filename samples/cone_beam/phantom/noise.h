// Counting noise of a detector.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cone_beam/geometry.h"

namespace gicube::samples {

// As if `photons` (> 0) left the source towards each pixel: a line integral p becomes -ln(N / photons), with N from Poisson's
// distribution of mean photons e^-p. Its deviation is about e^(p/2) / sqrt(photons). A pixel that no photon reaches counts
// as half a one; returned is how many such there are. The same seed makes the same noise, whatever the number of threads;
// views differ. Throws BadArgument (photons).
std::size_t add_poisson_noise(Projections& projections, double photons, std::uint64_t seed);

}  // namespace gicube::samples

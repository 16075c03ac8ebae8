// Pictures of parts of a volume put together by radix-k [Peterka, Goodell, Ross, Shen, Thakur, "A Configurable Algorithm for Parallel
// Image-Compositing Applications", SC 2009]: in each round groups of k ranks divide the picture that they have in common among them, so
// that after rounds of k1, k2, ... with k1 k2 ... = ranks each has a part of the whole one. Only runs of active pixels, those with any
// opacity or colour, are sent.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gicube/ray_exchange.h"

namespace gicube {

// Colour premultiplied, 1 = one.
struct FloatPixel {
  float red = 0, green = 0, blue = 0, alpha = 0;
};

// Collective. `order`: the ranks from front to back, the same on each. `pixels`: this rank's picture, equally many on each. Behind a
// pixel whose alpha is at least `threshold` nothing is added. Rank 0 gets the whole picture, others none. `bytes_sent` is increased by what
// went to other ranks, without the gathering. Throws Error.
std::vector<FloatPixel> composite(RayExchange& exchange, std::span<const int> order, std::vector<FloatPixel> pixels,
                                  float threshold, std::uint64_t& bytes_sent);

// The k of each round: divisors of at most eight as long as there are some.
std::vector<int> radices(int ranks);

}  // namespace gicube

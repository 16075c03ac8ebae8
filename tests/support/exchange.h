// The light between two bodies that stand anywhere in the board's volume, to a wished accuracy.
#pragma once

#include <cstdint>
#include <span>

#include "gicube/board.h"
#include "gicube/pair.h"

namespace gicube::samples {

struct ExchangeSettings {
  double error = 0.002;  // > 0: standard error that is asked for, a share of the result
  int rays = 64;         // of each pair of parts; 8..65536
  std::uint64_t max_rays = 1u << 23;
  std::uint32_t seed = 0;
  PairRays made = PairRays::kByBoard;
  Vec3 edges{1, 1, 1};  // of a voxel, physical: in smallest voxel edges
};

struct Exchange {
  // Double integral of f f T / (pi r^2), f the cosine at a patch and 1 in a box: of two patches the exchange area, area times
  // form factor; with boxes to be multiplied with the extinction of each.
  double value = 0;
  double standard_error = 0;  // with what rays may not have found between parts that are still near
  std::uint64_t rays = 0;
  std::uint64_t pairs = 0;  // of parts, at the end
};

// Of all of `a` to all of `b`, each the sum of its elements, which may touch, overlap or be the same: 1/r^2 has no bound then,
// and the mean of few rays is too low. So parts that are near for their size are halved until little light goes between them,
// and others where the rays' spread asks for it. Ends at max_rays with the standard error that it has come to.
// Throws InputError (an element without area or volume, by list and index; settings), and what Board throws.
Exchange exchange_between(Board& board, std::span<const Element> a, std::span<const Element> b,
                          const ExchangeSettings& settings = {});

}  // namespace gicube::samples

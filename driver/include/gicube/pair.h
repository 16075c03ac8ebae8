// How much light goes between pairs of elements of the volume: the heaviest part of radiosity [P §5.6].
//
//   auto factors = board.pair_factors(elements, pairs, {.rays = 64});
//   // exchange area of two patches: factors[i].transported * area_a * area_b
#pragma once

#include <cstdint>

#include "gicube/vector.h"

namespace gicube {

enum class ElementKind {
  kPatch,  // origin + s u + t v, 0..1 each; its front is to the side of u x v
  kBox,    // origin + s u + t v + r w: a part of the volume
};

// In voxels; all corners inside the volume. Kept as floats.
struct Element {
  ElementKind kind = ElementKind::kPatch;
  Vec3 origin, u, v, w;
};

struct ElementPair {
  std::uint32_t a = 0, b = 0;  // indices of elements
  std::uint32_t id = 0;        // picks the points; pairs of different ids are independent experiments
};

// Who makes the rays. The results are the same to the bit; what crosses the bus is not.
enum class PairRays {
  kByBoard,  // the DSP: 12 bytes a pair and 56 an element down, 16 a pair up
  kByHost,   // the application's processor, as rays of type kOpacity: 32 bytes a ray each way
};

struct PairRequest {
  std::uint32_t rays = 16;  // for each pair, 1..65536; any number of them fills both elements evenly
  std::uint32_t first = 0;  // the pair's first sample: goes on where an earlier request ended
  std::uint32_t seed = 0;
  double opacity = 1;  // > 0..1: a ray that has gathered that much ends
  PairRays made = PairRays::kByBoard;
};

// Means over the rays, and so over both elements. r is the physical distance of two points (in smallest voxel edges), T the
// transmittance between them, and f the cosine at a patch (0 behind it), or 1 in a box.
struct PairFactor {
  double transported = 0;  // f f T / (pi r^2)
  double geometric = 0;    // f f / (pi r^2)
  // Of `transported`, from the means of eight runs of its samples: an upper bound, as a rule, since the runs fill the
  // elements less evenly than all; infinite for fewer than 8 rays.
  double standard_error = 0;
  // No ray was sent: the empty flags prove T = 1 for all of them. The other fields are the same bits as with rays.
  bool clear = false;

  friend constexpr bool operator==(const PairFactor&, const PairFactor&) = default;
};

}  // namespace gicube

// The light exchanged between pairs of elements of the volume: the heaviest part of radiosity [P §5.6].
//
//   auto factors = board.pair_factors(elements, pairs, {.rays = 64});
//   // form factor of two flat elements, from a to b: factors[i].transported * area_b
#pragma once

#include <cstdint>

#include "gicube/vector.h"

namespace gicube {

// Flat elements have their front to the side of u x v.
enum class ElementKind {
  kPatch,     // a parallelogram: origin + s u + t v, 0..1 each
  kBox,       // origin + s u + t v + r w: a part of the volume
  kTriangle,  // with the corners origin, origin + u, origin + v
  // origin + s u + t v, s^2 + t^2 <= 1: about its centre, with the half-axes u and v; a circle or an ellipse. For rings
  // and sectors: w.x is the hole's share of the area, and w.y the missing share of the turn, which begins at u and goes
  // towards v; each 0 or more and below 1. {} is a whole disc.
  kDisc,
};

// In voxels; wholly inside the volume. Kept as floats.
struct Element {
  ElementKind kind = ElementKind::kPatch;
  Vec3 origin{}, u{}, v{};
  Vec3 w{};  // of boxes and discs
};

struct ElementPair {           // two elements between which light goes
  std::uint32_t a = 0, b = 0;  // indices of elements
  std::uint32_t id = 0;        // picks the points; pairs of different ids are independent experiments
};

// Maker of the rays. The results have the same bits; the bytes on the bus differ.
enum class PairRays {
  // The DSP: 12 bytes per pair and 56 per element down, 16 per pair up; like kByHost with boards of version 0.1.
  kByBoard,
  kByHost,  // the application's processor, as rays of type kOpacity: 32 bytes per ray each way
};

struct PairRequest {  // rays for each pair, and how they are sampled
  // For each pair, 1..65536; any number of them fills both elements evenly. The parts of a near pair share them: none
  // has more, and some have a few less.
  std::uint32_t rays = 16;
  std::uint32_t first = 0;  // the first sample: one that no earlier request has used, if that ended before it
  std::uint32_t seed = 0;
  double opacity = 1;  // > 0..1: a ray that has gathered that much ends
  double step = 0.5;   // voxels between samples, 1/64..16; refused as View::step
  bool leap = true;    // over blocks whose empty flag is set
  PairRays made = PairRays::kByBoard;
};

// Means over both elements. r is the physical distance of two points (in smallest voxel edges), T the transmittance
// between them, and f the cosine at a flat element (0 behind it), or 1 in a box.
//
// The form factor F_ab, the share of a's diffuse light that arrives at b, follows with area A, volume V and extinction
// k of the elements, also in smallest voxel edges (where voxels are no cubes: not those of u and v):
//   F_ab = transported * A_b      a and b flat; the exchange area is A_a F_ab = A_b F_ba
//   F_ab = transported * k_b V_b  a flat, b a box: what b's medium takes up
//   F_ab = transported * A_b / 4, transported * k_b V_b / 4  a a box, which emits alike in all directions
//
// A far pair's means are those over its rays. A pair is near if the gap between its elements' bounds along the axes is
// below half of their longest side, edge or diameter. There f f / (pi r^2) has no bound that rays could know, so the
// driver divides such a pair into parts of about equal light, up to 1024. It knows `geometric` of each without rays
// (Sparrow 1963 for flat ones); the part's rays say which share of it arrives.
struct PairFactor {
  double transported = 0;  // f f T / (pi r^2)
  double geometric = 0;    // f f / (pi r^2)
  // Standard error of `transported`: the truth is within three of them for at least 99 of 100 pairs. Infinite for fewer
  // than 8 rays of a far pair.
  // - Far: computed from the means of eight runs of the rays, and multiplied by 1.8 because they are so few. The runs
  //   complement one another, so the true scatter is less: about a fifth with 64 rays through a homogeneous medium,
  //   about an eighth with 1024. A term is added for features that no ray has hit: about 1.4 / (rays + 4) of the value,
  //   so that few rays alone are never certain, and up to 1 / (rays + 4) of `geometric` where most rays end at
  //   something opaque.
  // - Near: the largest variation of rays that either arrive or not, plus the error of the closed forms. It is wide,
  //   about 3 to 10 times the true scatter, through a homogeneous medium, between boxes that touch or overlap, and for
  //   fewer than about 256 rays.
  // Rounding on the board (opacities, positions) is not included: docs/studies/accuracy.md.
  double standard_error = 0;
  // No ray was sent: the empty flags prove T = 1 for all of them. `transported` and `geometric` are the same bits as
  // with rays; the error has no share for what rays may not have found.
  bool clear = false;

  friend constexpr bool operator==(const PairFactor&, const PairFactor&) = default;
};

}  // namespace gicube

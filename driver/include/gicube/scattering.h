// Scattering by the application: the event of a ray that met such a material, and the application's answer.
#pragma once

#include <array>
#include <functional>
#include <span>

#include "gicube/vector.h"

namespace gicube {

// Directions are unit vectors in physical space (axes parallel to the voxel axes).
struct ScatterEvent {
  Vec3 position;       // voxels
  Vec3 direction;      // in which the ray travels
  Vec3 normal;         // against the density's gradient, away from dense matter; zero where there is no gradient
  double opacity = 0;  // of one voxel length of the material there, 0..1
  double density = 0;  // 0..4095, the board's (Board::value_range() maps values to it)
  int tag = 0;
  bool lighting = false;           // a lighting ray, which carries energy from a light; else one from the eye
  int generation = 0;              // how often the ray was scattered before, at most 15
  std::array<double, 4> random{};  // even in [0, 1), of this event alone: the only randomness that pictures repeat with
  std::span<const float> parameters{};  // Material::parameters; lives as long as the call
};

struct ScatterAnswer {  // the outcome of a scattering
  Vec3 direction;       // in which the ray continues; physical, of a length from 1e-6 to 1e6
  double passes = 1;    // the share of its energy, or of what it can still gather, that continues: 0..1
};

// Called on the thread that called the Board, one ray at a time, in an order that does not depend on the board.
using ScatteringRoutine = std::function<ScatterAnswer(const ScatterEvent&)>;

}  // namespace gicube

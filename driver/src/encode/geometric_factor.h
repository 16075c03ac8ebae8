// Light between two elements that see each other, without rays: PairFactor::geometric by closed forms, which stay
// finite where the elements touch. Samples of f f / (pi r^2) are unbounded there.
#pragma once

#include "gicube/pair.h"

namespace gicube {

struct GeometricFactor {
  double mean = 0;   // of f f / (pi r^2) over both elements
  double error = 0;  // change with one Gauss point less, and half the chords of discs
};

// The factor of elements in physical coordinates, in smallest voxel edges; w of a disc is unchanged. For two boxes that
// are not near, a few sample points of both suffice.
GeometricFactor geometric_factor(const Element& a, const Element& b, bool near);

double measure_of(const Element& element);  // its area or volume

}  // namespace gicube

// The shape of C60: 60 atoms on the corners of a truncated icosahedron, 90 bonds along its edges.
#pragma once

#include <array>
#include <vector>

#include "gicube/vector.h"

namespace gicube::samples {

struct Molecule {
  std::vector<Vec3> atoms;
  std::vector<std::array<int, 2>> bonds;  // indices of atoms, the smaller first
};

// Centred on the origin, all atoms at distance 1 from it, one pentagon's centre on the +z axis.
Molecule truncated_icosahedron();

}  // namespace gicube::samples

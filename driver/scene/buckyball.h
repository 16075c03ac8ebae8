// A procedural scene: a C60 buckyball (60 atom spheres, 90 bond cylinders) hovers above a tiled floor.
// z is up. Analytic signed distances make densities, material tags and normals, so any size shows the same scene.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gicube/scene/scene.h"
#include "gicube/scene/voxeliser.h"
#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "scene/geometry/signed_distance.h"

namespace gicube::scene {

// The material tag of each part.
enum BuckyballTag : std::uint8_t { kAtom = 0, kBond = 1, kFloor = 2, kFloorDark = 3 };

// The shape of C60: 60 atoms on the corners of a truncated icosahedron, 90 bonds along its edges.
struct Molecule {
  std::vector<Vec3> atoms;
  std::vector<std::array<int, 2>> bonds;  // indices of atoms, the smaller first
};

// Centred on the origin, all atoms at distance 1 from it, one pentagon's centre on the +z axis.
Molecule truncated_icosahedron();

// A sphere for each atom, a capsule for each bond.
std::vector<Field> atom_fields(const Molecule& molecule, double radius);
std::vector<Field> bond_fields(const Molecule& molecule, double radius);

// Lengths as parts of the volume's edge, which is size - 1 voxels.
struct BuckyballShape {
  Vec3 centre{0.5, 0.5, 0.545};
  double circumradius = 0.355;
  double atom_radius = 0.05;
  double bond_radius = 0.021;
  Vec3 floor_low{0.015, 0.015, 0.03};
  Vec3 floor_high{0.985, 0.985, 0.075};
  double floor_rounding = 0.012;
  int floor_tiles = 8;      // along x and along y
  double turn_degrees = 9;  // about the vertical axis, so that no bond hides another from the default camera
};

// size^3 voxels with a BuckyballTag each; the same for any number of threads (0 = one per core). Throws InputError if
// the size is out of range.
VoxelWorld make_buckyball(int size, bool gradients, int threads = 0, const BuckyballShape& shape = {});

// The default appearance of the scene: absolute transfer functions by tag, light, camera (in voxels) and background.
Appearance buckyball_appearance(int size);

}  // namespace gicube::scene

#include "scene/truncated_icosahedron.h"

#include <cmath>
#include <numbers>

namespace gicube::samples {
namespace {

constexpr double kPhi = std::numbers::phi;
constexpr double kEdge = 2;  // of the coordinates below

// The three even permutations of (x, y, z) under every choice of signs; a zero has no sign.
void add_orbit(Vec3 corner, std::vector<Vec3>& atoms) {
  for (int signs = 0; signs < 8; ++signs) {
    const double sx = (signs & 1) != 0 ? -1 : 1, sy = (signs & 2) != 0 ? -1 : 1, sz = (signs & 4) != 0 ? -1 : 1;
    if (corner.x == 0 && sx < 0) continue;
    const Vec3 p{sx * corner.x, sy * corner.y, sz * corner.z};
    atoms.insert(atoms.end(), {p, Vec3{p.y, p.z, p.x}, Vec3{p.z, p.x, p.y}});
  }
}

}  // namespace

Molecule truncated_icosahedron() {
  Molecule molecule;
  add_orbit({0, 1, 3 * kPhi}, molecule.atoms);
  add_orbit({1, 2 + kPhi, 2 * kPhi}, molecule.atoms);
  add_orbit({2, 1 + 2 * kPhi, kPhi}, molecule.atoms);

  const int count = static_cast<int>(molecule.atoms.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      const double distance =
          length(molecule.atoms[static_cast<std::size_t>(a)] - molecule.atoms[static_cast<std::size_t>(b)]);
      if (std::abs(distance - kEdge) < 1e-6) molecule.bonds.push_back({a, b});
    }
  }

  // (0, 1, phi) is a five-fold axis: turn it about x onto +z, and scale to a unit circumradius.
  const double norm = std::hypot(1.0, kPhi), cosine = kPhi / norm, sine = 1 / norm;
  for (Vec3& p : molecule.atoms) {
    const Vec3 turned{p.x, cosine * p.y - sine * p.z, sine * p.y + cosine * p.z};
    p = normalise(turned);
  }
  return molecule;
}

}  // namespace gicube::samples

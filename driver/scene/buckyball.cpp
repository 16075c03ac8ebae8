#include "scene/buckyball.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "gicube/scene/error.h"
#include "scene/common/cells.h"

namespace gicube::scene {
namespace {

constexpr double kPhi = std::numbers::phi;
constexpr double kBondLength = 2;  // of the coordinates below

// The three even permutations of (x, y, z) under every choice of signs; a zero has no sign.
void add_orbit(Vec3 corner, std::vector<Vec3>& atoms) {
  for (int signs = 0; signs < 8; ++signs) {
    const double sx = (signs & 1) != 0 ? -1 : 1, sy = (signs & 2) != 0 ? -1 : 1, sz = (signs & 4) != 0 ? -1 : 1;
    if (corner.x == 0 && sx < 0) continue;
    const Vec3 p{sx * corner.x, sy * corner.y, sz * corner.z};
    atoms.insert(atoms.end(), {p, Vec3{p.y, p.z, p.x}, Vec3{p.z, p.x, p.y}});
  }
}

struct Solid {
  Field field;
  std::uint8_t tag;
};

// All solids in voxels. `scale` is the volume's edge.
std::vector<Solid> place_solids(const BuckyballShape& shape, double scale) {
  Molecule molecule = truncated_icosahedron();
  const double turn = shape.turn_degrees * std::numbers::pi / 180, cosine = std::cos(turn), sine = std::sin(turn);
  for (Vec3& p : molecule.atoms) {
    const Vec3 turned{cosine * p.x - sine * p.y, sine * p.x + cosine * p.y, p.z};
    p = scale * (shape.centre + shape.circumradius * turned);
  }
  std::vector<Solid> solids;
  for (const Field& atom : atom_fields(molecule, scale * shape.atom_radius)) solids.push_back({atom, kAtom});
  for (const Field& bond : bond_fields(molecule, scale * shape.bond_radius)) solids.push_back({bond, kBond});
  const Vec3 low = scale * shape.floor_low, high = scale * shape.floor_high;
  const double rounding = scale * shape.floor_rounding;
  solids.push_back({[=](Vec3 p) { return box_distance(p, low, high, rounding); }, kFloor});
  return solids;
}

// The tag of a floor with two kinds of tiles.
std::uint8_t floor_tag(const BuckyballShape& shape, Vec3 p) {
  const auto tile = [&shape](double v, double low, double high) {
    return static_cast<int>(std::floor((v - low) / (high - low) * shape.floor_tiles));
  };
  const int sum = tile(p.x, shape.floor_low.x, shape.floor_high.x) + tile(p.y, shape.floor_low.y, shape.floor_high.y);
  return (sum & 1) == 0 ? kFloor : kFloorDark;
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
      if (std::abs(distance - kBondLength) < 1e-6) molecule.bonds.push_back({a, b});
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

std::vector<Field> atom_fields(const Molecule& molecule, double radius) {
  std::vector<Field> fields;
  for (const Vec3& a : molecule.atoms) fields.push_back([=](Vec3 p) { return sphere_distance(p, a, radius); });
  return fields;
}

std::vector<Field> bond_fields(const Molecule& molecule, double radius) {
  std::vector<Field> fields;
  for (const auto& [from, to] : molecule.bonds) {
    const Vec3 a = molecule.atoms[static_cast<std::size_t>(from)], b = molecule.atoms[static_cast<std::size_t>(to)];
    fields.push_back([=](Vec3 p) { return capsule_distance(p, a, b, radius); });
  }
  return fields;
}

VoxelWorld make_buckyball(int size, bool gradients, int threads, const BuckyballShape& shape) {
  if (size < kMinBuckyballSize || size > kMaxBuckyballSize) {
    throw InputError("buckyball size",
                     std::to_string(kMinBuckyballSize) + " to " + std::to_string(kMaxBuckyballSize) + " voxels",
                     std::to_string(size));
  }
  const Dims dims{size, size, size};
  const double scale = size - 1;  // voxels
  VoxelWorld ball(dims, "builtin:buckyball", gradients);
  const std::vector<Solid> solids = place_solids(shape, scale);
  each_cell(dims, threads, [&](const Dims& first) {
    const double reach = kNearVoxels + kCell * std::numbers::sqrt3 / 2;
    std::vector<const Solid*> near;
    for (const Solid& solid : solids) {
      if (solid.field(middle_of_cell(first)).distance < reach) near.push_back(&solid);
    }
    if (near.empty()) return;
    each_voxel(dims, first, [&](Vec3 p, std::size_t index) {
      Distance nearest{kNearVoxels, {}};
      const Solid* solid = nullptr;
      for (const Solid* candidate : near) {
        const Distance distance = candidate->field(p);
        if (distance.distance < nearest.distance) nearest = distance, solid = candidate;
      }
      if (solid == nullptr) return;
      ball.set_density(index, std::clamp(0.5 - nearest.distance / kRampVoxels, 0.0, 1.0));
      const Vec3 relative{p.x / scale, p.y / scale, p.z / scale};
      ball.tags[index] = solid->tag == kFloor ? floor_tag(shape, relative) : solid->tag;
      if (gradients && nearest.distance > -kNearVoxels) ball.set_gradient(index, -1 * nearest.away);
    });
  });
  return ball;
}

Appearance buckyball_appearance(int size) {
  // Opaque within about one voxel around the surface, which is at half of the greatest density.
  const auto solid = [](const Colour& colour) {
    return TransferFunctionFile{{{{0, colour}}, {{0.3 * kMaxDensity, 0}, {0.7 * kMaxDensity, 1}}}};
  };
  Appearance look;
  look.materials = {solid({0.93, 0.52, 0.20}), solid({0.66, 0.69, 0.74}), solid({0.52, 0.60, 0.70}),
                    solid({0.36, 0.43, 0.54})};
  look.phong = {0.22, 0.74, 0.42, 28};
  look.light = Vec3{-0.55, -0.62, 0.78};
  const double scale = size - 1;
  look.camera.look_at = scale * Vec3{0.5, 0.5, 0.455};
  look.camera.eye = scale * Vec3{0.5, -1.83, 1.36};
  look.camera.up = Vec3{0, 0, 1};
  look.camera.fov_degrees = 30;
  look.background = Colour{0.075, 0.085, 0.11};
  return look;
}

}  // namespace gicube::scene

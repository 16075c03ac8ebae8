#include "scene/geometry/shape.h"

#include <cmath>

#include "scene/buckyball.h"
#include "scene/geometry/head_shape.h"
#include "scene/geometry/mesh_distance.h"
#include "scene/geometry/mesh_file.h"
#include "scene/program/checks.h"
#include "scene/truncated_icosahedron.h"

namespace gicube::samples {
namespace {

void check_rounding(double rounding, double shortest) {
  require(rounding >= 0 && rounding <= shortest / 2, "rounding", "0 to half of the shortest edge", rounding);
}

void check_shape(const SphereShape& s) { require_above_0("radius", s.radius); }

void check_shape(const BoxShape& s) {
  const Vec3 edge = s.high - s.low;
  require_above_0("high.x - low.x", edge.x);
  require_above_0("high.y - low.y", edge.y);
  require_above_0("high.z - low.z", edge.z);
  check_rounding(s.rounding, std::min({edge.x, edge.y, edge.z}));
}

void check_shape(const TorusShape& s) {
  require_above_0("radius", s.radius);
  require_above_0("tube", s.tube);
  require(s.tube < s.radius, "tube", "less than the radius", s.tube);
}

void check_shape(const CylinderShape& s) {
  require_above_0("radius", s.radius);
  require_above_0("height", s.height);
  require(s.inner_radius >= 0 && s.inner_radius < s.radius, "inner_radius", "0 to less than the radius",
          s.inner_radius);
  check_rounding(s.rounding, std::min(s.inner_radius > 0 ? s.radius - s.inner_radius : 2 * s.radius, s.height));
}

void check_shape(const MeshShape& s) {
  if (!s.mesh && s.file.empty()) throw InputError("file", "a mesh", "none");
}

void check_shape(const BuiltinShape& s) {
  for (const char* name : {"buckyball", "buckyball_atoms", "buckyball_bonds", "head"}) {
    if (s.name == name) return;
  }
  throw InputError("builtin", "buckyball, buckyball_atoms, buckyball_bonds or head", in_quotes(s.name));
}

std::vector<Field> buckyball_fields(bool atoms, bool bonds) {
  const BuckyballShape shape;
  const double atom = shape.atom_radius / shape.circumradius, bond = shape.bond_radius / shape.circumradius;
  const Molecule molecule = truncated_icosahedron();
  std::vector<Field> result;
  if (atoms) {
    for (const Vec3& a : molecule.atoms) result.push_back([a, atom](Vec3 p) { return sphere_distance(p, a, atom); });
  }
  if (bonds) {
    for (const auto& [from, to] : molecule.bonds) {
      const Vec3 a = molecule.atoms[static_cast<std::size_t>(from)], b = molecule.atoms[static_cast<std::size_t>(to)];
      result.push_back([a, b, bond](Vec3 p) { return capsule_distance(p, a, b, bond); });
    }
  }
  return result;
}

std::vector<Field> fields(const SphereShape& s) {
  return {[s](Vec3 p) { return sphere_distance(p, {}, s.radius); }};
}

std::vector<Field> fields(const BoxShape& s) {
  return {[s](Vec3 p) { return box_distance(p, s.low, s.high, s.rounding); }};
}

std::vector<Field> fields(const TorusShape& s) {
  return {[s](Vec3 p) { return torus_distance(p, s.radius, s.tube); }};
}

std::vector<Field> fields(const CylinderShape& s) {
  return {[s](Vec3 p) { return cylinder_distance(p, s.inner_radius, s.radius, s.height, s.rounding); }};
}

std::vector<Field> fields(const MeshShape& s) {
  const std::string name = s.mesh ? "mesh" : s.file.string();
  const auto distance = std::make_shared<const MeshDistance>(s.mesh ? *s.mesh : read_mesh(s.file), name);
  return {[distance](Vec3 p) { return distance->at(p); }};
}

std::vector<Field> fields(const BuiltinShape& s) {
  if (s.name == "head") return {head_bound};
  return buckyball_fields(s.name != "buckyball_bonds", s.name != "buckyball_atoms");
}

}  // namespace

void check(const Shape& shape) {
  std::visit([](const auto& s) { check_shape(s); }, shape);
}

std::vector<Field> fields_of(const Shape& shape) {
  check(shape);
  return std::visit([](const auto& s) { return fields(s); }, shape);
}

}  // namespace gicube::samples

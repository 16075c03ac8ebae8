#include "gicube/scene/shape.h"

#include <cmath>

#include "scene/buckyball.h"
#include "scene/common/checks.h"
#include "scene/geometry/mesh_distance.h"
#include "scene/geometry/mesh_file.h"
#include "scene/geometry/signed_distance.h"

namespace gicube::scene {
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

void check_shape(const FieldShape& s) {
  if (!s.field || !*s.field) throw InputError("field", "a function", "none");
}

void check_shape(const BuiltinShape& s) {
  for (const char* name : {"buckyball", "buckyball_atoms", "buckyball_bonds", "head"}) {
    if (s.name == name) return;
  }
  throw InputError("builtin", "buckyball, buckyball_atoms, buckyball_bonds or head", in_quotes(s.name));
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

std::vector<Field> fields(const FieldShape& s) { return {*s.field}; }

std::vector<Field> fields(const BuiltinShape& s) {
  if (s.name == "head") return {head_bound};
  const BuckyballShape shape;
  const Molecule molecule = truncated_icosahedron();
  std::vector<Field> result = atom_fields(molecule, shape.atom_radius / shape.circumradius);
  if (s.name == "buckyball_bonds") result.clear();
  if (s.name != "buckyball_atoms")
    std::ranges::copy(bond_fields(molecule, shape.bond_radius / shape.circumradius), std::back_inserter(result));
  return result;
}

Distance outside_of(Distance d) { return {-d.distance, -1 * d.away}; }

// The union, with a fillet where the solids are within `width` of each other (polynomial smooth minimum). Its gradient
// is the same mix of gradients as its value is of values.
Distance blend(Distance a, Distance b, double width) {
  const double share = std::clamp(0.5 + 0.5 * (b.distance - a.distance) / width, 0.0, 1.0);
  return {share * a.distance + (1 - share) * b.distance - width * share * (1 - share),
          share * a.away + (1 - share) * b.away};
}

Distance carve(Distance from, Distance hollow, double width) {
  return outside_of(blend(outside_of(from), hollow, width));
}

}  // namespace

Distance head_bound(Vec3 p) {
  const Vec3 q{std::abs(p.x), p.y, p.z};  // both sides are alike
  Distance head = ellipsoid_bound(q, {0, 0.1, 0.26}, {0.56, 0.7, 0.6});
  head = blend(head, ellipsoid_bound(q, {0, -0.14, -0.2}, {0.43, 0.5, 0.58}), 0.14);         // face and jaw
  head = blend(head, ellipsoid_bound(q, {0, -0.52, -0.66}, {0.17, 0.14, 0.12}), 0.1);        // chin
  head = blend(head, ellipsoid_bound(q, {0.25, -0.5, -0.16}, {0.13, 0.1, 0.12}), 0.1);       // cheeks
  head = blend(head, ellipsoid_bound(q, {0.17, -0.585, 0.21}, {0.17, 0.06, 0.05}), 0.06);    // brows
  head = carve(head, sphere_distance(q, {0.19, -0.69, 0.07}, 0.13), 0.06);                   // sockets
  head = blend(head, sphere_distance(q, {0.19, -0.52, 0.07}, 0.1), 0.01);                    // eyes
  head = blend(head, capsule_distance(q, {0, -0.6, 0.14}, {0, -0.74, -0.13}, 0.055), 0.07);  // nose
  head = blend(head, ellipsoid_bound(q, {0.06, -0.66, -0.16}, {0.06, 0.07, 0.05}), 0.03);    // nostrils
  head = blend(head, ellipsoid_bound(q, {0, -0.64, -0.365}, {0.16, 0.055, 0.035}), 0.03);    // lips
  head = blend(head, ellipsoid_bound(q, {0, -0.63, -0.435}, {0.13, 0.055, 0.035}), 0.02);
  head = blend(head, capsule_distance(q, {0, 0.14, -0.4}, {0, 0.24, -0.85}, 0.3), 0.12);  // neck
  Distance ear = ellipsoid_bound(q, {0.55, 0.12, 0.02}, {0.07, 0.15, 0.2});
  ear = carve(ear, ellipsoid_bound(q, {0.64, 0.09, 0.03}, {0.06, 0.09, 0.13}), 0.03);
  const double side = std::copysign(1.0, p.x);
  head = blend(head, ear, 0.04);
  head.away.x *= side;
  return head;
}

void check(const Shape& shape) {
  std::visit([](const auto& s) { check_shape(s); }, shape);
}

std::vector<Field> fields_of(const Shape& shape) {
  check(shape);
  return std::visit([](const auto& s) { return fields(s); }, shape);
}

}  // namespace gicube::scene

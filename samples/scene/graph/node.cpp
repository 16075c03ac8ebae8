#include "scene/graph/node.h"

#include <fmt/format.h>

#include <cmath>

#include "scene/program/input_error.h"

namespace gicube::samples {
namespace {

bool finite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

std::string shown_point(Vec3 v) { return fmt::format("{} {} {}", v.x, v.y, v.z); }

Affine map(const Translate& t) {
  if (!finite(t.by)) throw InputError("translate", "finite numbers", shown_point(t.by));
  return translation(t.by);
}

Affine map(const Rotate& r) {
  if (!finite(r.axis) || !(length(r.axis) > 0)) throw InputError("rotate.axis", "a direction", shown_point(r.axis));
  if (!std::isfinite(r.degrees)) throw InputError("rotate.degrees", "a finite number", fmt::format("{}", r.degrees));
  return rotation(r.axis, r.degrees);
}

Affine map(const Scale& s) {
  if (!finite(s.by) || s.by.x == 0 || s.by.y == 0 || s.by.z == 0) {
    throw InputError("scale", "finite numbers other than 0", shown_point(s.by));
  }
  return scaling(s.by);
}

}  // namespace

Affine map_of(const std::vector<Transform>& transforms) {
  Affine result;
  for (const Transform& transform : transforms) {
    result = compose(std::visit([](const auto& t) { return map(t); }, transform), result);
  }
  return result;
}

}  // namespace gicube::samples

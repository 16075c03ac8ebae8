#include "gicube/scene/world.h"

#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

Affine map(const Translate& t) {
  require_finite("translate", t.by);
  return translation(t.by);
}

Affine map(const Rotate& r) {
  if (!is_finite(r.axis) || !(length(r.axis) > 0)) throw InputError("rotate.axis", "a direction", shown_point(r.axis));
  if (!std::isfinite(r.degrees)) throw InputError("rotate.degrees", "a finite number", shown(r.degrees));
  return rotation(r.axis, r.degrees);
}

Affine map(const Scale& s) {
  if (!is_finite(s.by) || s.by.x == 0 || s.by.y == 0 || s.by.z == 0) {
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

}  // namespace gicube::scene

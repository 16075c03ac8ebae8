#include "firmware/lamps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/lighting_rays.h"
#include "gicube/wire/registers.h"

namespace gicube::emu {

namespace {

constexpr std::uint32_t kRecordBytes = 64;  // 16 words

}  // namespace

std::optional<std::string> Lamps::fault(const wire::Lamp& lamp) {
  if (lamp.kind != wire::LightKind::kRectangle && lamp.kind != wire::LightKind::kSphere) {
    return "kind: expected 2 (rectangle) or 3 (sphere), got " + std::to_string(static_cast<unsigned>(lamp.kind));
  }
  return LightingRays::geometry_fault({.kind = lamp.kind, .position = lamp.position, .u = lamp.u, .v = lamp.v});
}

Lamps::Lamps(std::span<const wire::Lamp> lamps, const std::array<std::uint32_t, 3>& spacing) {
  for (std::size_t axis = 0; axis < 3; ++axis) spacing_[axis] = spacing[axis] / static_cast<double>(wire::kSpacingOne);
  for (const wire::Lamp& lamp : lamps) {
    Shape shape{.sphere = lamp.kind == wire::LightKind::kSphere};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      shape.colour[axis] = lamp.colour[axis] * (wire::kColourOne / 65536.0);
      shape.place[axis] = lamp.position[axis] * spacing_[axis];
    }
    if (shape.sphere) {
      shape.radius = lamp.u[0];
    } else {
      shape.normal = cross(lamp.u, lamp.v);
      const double size = dot(shape.normal, shape.normal);
      shape.along_u = scaled(cross(lamp.v, shape.normal), 1 / size);
      shape.along_v = scaled(cross(shape.normal, lamp.u), 1 / size);
    }
    lamps_.push_back(shape);
  }
}

double Lamps::distance(const Shape& shape, const Vector& start, const Vector& direction) {
  const Vector from = difference(start, shape.place);
  if (shape.sphere) {
    const double a = dot(direction, direction), b = dot(from, direction);
    const double c = dot(from, from) - shape.radius * shape.radius, root = b * b - a * c;
    return c < 0 || b >= 0 || root < 0 ? -1 : (-b - std::sqrt(root)) / a;
  }
  const double towards = dot(direction, shape.normal);
  if (!(towards < 0)) return -1;
  const double t = -dot(from, shape.normal) / towards;
  const Vector met = along(from, t, direction);
  const double along_u = dot(met, shape.along_u), along_v = dot(met, shape.along_v);
  return along_u >= 0 && along_u <= 1 && along_v >= 0 && along_v <= 1 ? t : -1;
}

DspTask Lamps::task(const wire::Ray& ray) const {
  if (empty() || !looks(ray)) return {};
  const auto count = static_cast<std::uint32_t>(lamps_.size());
  DspTask task{.loop = &kTestLamp, .more_cycles = kLookForLamps.interval() + (count - 1) * kTestLamp.interval()};
  return task.with({sdram_map::kTables, count * kRecordBytes, SdramUse::Kind::kRead});
}

wire::Ray Lamps::seen_by(wire::Ray ray) const {
  if (empty() || !looks(ray)) return ray;
  Vector start{}, direction{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    start[axis] = ray.position[axis] / static_cast<double>(wire::kVoxel) * spacing_[axis];
    direction[axis] = ray.direction[axis] * spacing_[axis];
  }
  const Shape* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const Shape& shape : lamps_) {
    const double t = distance(shape, start, direction);
    if (t < 0 || t >= least) continue;
    least = t;
    nearest = &shape;
  }
  if (nearest == nullptr) return ray;
  const double through = (wire::kOpacityOne - ray.opacity) / static_cast<double>(wire::kOpacityOne);
  for (std::size_t c = 0; c < 3; ++c) {
    const double sum = ray.colour[c] + std::floor(through * nearest->colour[c] + 0.5);
    ray.colour[c] = static_cast<std::uint16_t>(std::min<double>(sum, wire::kColourOne));
  }
  ray.opacity = wire::kOpacityOne;
  return ray;
}

}  // namespace gicube::emu

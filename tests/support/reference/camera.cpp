#include "camera.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace gicube::reference {

namespace {

Vec3 to_physical(Vec3 v, Vec3 spacing) { return {v.x * spacing.x, v.y * spacing.y, v.z * spacing.z}; }
Vec3 to_voxels(Vec3 v, Vec3 spacing) { return {v.x / spacing.x, v.y / spacing.y, v.z / spacing.z}; }

// Keeps what of the interval has normal . (origin + t direction) >= offset.
void keep(Interval& interval, const Line& line, Vec3 normal, double offset) {
  const double distance = dot(normal, line.origin) - offset;
  const double rate = dot(normal, line.direction);
  if (rate > 0) {
    interval.begin = std::max(interval.begin, -distance / rate);
  } else if (rate < 0) {
    interval.end = std::min(interval.end, -distance / rate);
  } else if (distance < 0) {
    interval.end = -1;
  }
}

}  // namespace

Camera::Camera(const View& view, Vec3 spacing)
    : perspective_(!(view.orthographic_height > 0)),
      spacing_(spacing),
      eye_(to_physical(view.eye, spacing)),
      forward_(normalise(to_physical(view.look_at, spacing) - eye_)),
      middle_x_(view.width / 2.0),
      middle_y_(view.height / 2.0) {
  right_ = normalise(cross(forward_, to_physical(view.up, spacing)));
  up_ = cross(right_, forward_);
  const double half_angle = view.fov_degrees / 2 * std::numbers::pi / 180;
  pixel_ = (perspective_ ? 2 * std::tan(half_angle) : view.orthographic_height) / view.height;
}

Line Camera::line(double x, double y) const {
  const Vec3 across = pixel_ * (x - middle_x_) * right_ + pixel_ * (middle_y_ - y) * up_;
  const Vec3 origin = perspective_ ? eye_ : eye_ + across;
  const Vec3 direction = perspective_ ? forward_ + across : forward_;
  return {to_voxels(origin, spacing_), normalise(to_voxels(direction, spacing_))};
}

std::optional<Interval> clip(const Line& line, Dims dims, std::span<const CutPlane> planes) {
  Interval interval{0, std::numeric_limits<double>::infinity()};
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    keep(interval, line, axes[axis], 0);
    keep(interval, line, -1.0 * axes[axis], 1.0 - dims[axis]);
  }
  for (const CutPlane& plane : planes) keep(interval, line, plane.normal, plane.offset);
  if (!(interval.begin <= interval.end)) return std::nullopt;
  return interval;
}

}  // namespace gicube::reference

#include "light/transport/eye.h"

#include <cmath>
#include <numbers>

#include "gicube/scene/error.h"

namespace gicube::samples {

Eye::Eye(const View& view, const Medium& medium)
    : width_(view.width), height_(view.height), eye_(medium.place_of(view.eye)) {
  if (view.orthographic_height > 0) {
    throw InputError("camera.orthographic_height", "a perspective camera", std::to_string(view.orthographic_height));
  }
  forward_ = normalise(medium.place_of(view.look_at) - eye_);
  right_ = normalise(cross(forward_, medium.place_of(view.up)));
  up_ = cross(right_, forward_);
  pixel_ = 2 * std::tan(view.fov_degrees / 2 * std::numbers::pi / 180) / view.height;
}

Vec3 Eye::direction(double x, double y) const {
  return normalise(forward_ + pixel_ * (x - width_ / 2.0) * right_ + pixel_ * (height_ / 2.0 - y) * up_);
}

std::optional<std::size_t> Eye::pixel_of(Vec3 direction) const {
  const double ahead = dot(direction, forward_);
  if (!(ahead > 0)) return std::nullopt;
  const double x = std::floor(width_ / 2.0 + dot(direction, right_) / (ahead * pixel_));
  const double y = std::floor(height_ / 2.0 - dot(direction, up_) / (ahead * pixel_));
  if (!(x >= 0 && x < width_ && y >= 0 && y < height_)) return std::nullopt;
  return static_cast<std::size_t>(y) * width() + static_cast<std::size_t>(x);
}

double Eye::density(Vec3 direction) const {
  const double ahead = dot(direction, forward_);
  return ahead > 0 ? 1 / (pixel_ * pixel_ * ahead * ahead * ahead) : 0;
}

}  // namespace gicube::samples

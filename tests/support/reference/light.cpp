#include "light.h"

#include <algorithm>
#include <cmath>

#include "encode/look_up_tables.h"
#include "gicube/wire/lut.h"

namespace gicube::reference {

namespace {

constexpr double kShortestGradient = 1.0 / 16;
constexpr double kFade = 0.1;            // N.L below which the highlight fades
constexpr double kCoefficientOne = 128;  // of the board's shading coefficients and map

double to_coefficient(double v) { return std::round(v * kCoefficientOne) / kCoefficientOne; }

}  // namespace

Light::Light(const Shading& shading, Vec3 towards_eye, const Quantisers& quantisers)
    : phong_(shading.phong),
      light_(shading.light == Vec3{} ? towards_eye : normalise(shading.light)),
      towards_eye_(towards_eye),
      ambient_(shading.phong.ambient),
      knee_(shading.phong.ambient + shading.phong.diffuse) {
  if (!quantisers.reflectance) return;
  map_ = reflectance_map(phong_, light_, towards_eye_);
  ambient_ = to_coefficient(ambient_);
  knee_ = to_coefficient(knee_);
}

std::array<double, 3> Light::shade(const std::array<double, 3>& colour, Vec3 gradient) const {
  if (length(gradient) < kShortestGradient) return colour;
  const Vec3 normal = -1.0 * normalise(gradient);
  const double total = ambient_ + (map_.empty() ? reflected(normal) : looked_up(normal));
  const double base = std::min(total, knee_);
  const double highlight = total - base;
  std::array<double, 3> lit{};
  for (std::size_t c = 0; c < 3; ++c) lit[c] = std::min(1.0, colour[c] * base + highlight);
  return lit;
}

double Light::reflected(Vec3 normal) const {
  const double facing = dot(normal, light_);
  if (facing <= 0) return 0;
  const Vec3 mirrored = 2 * facing * normal - light_;
  const double towards = std::max(dot(mirrored, towards_eye_), 0.0);
  const double fade = std::clamp(facing / kFade, 0.0, 1.0);
  return phong_.diffuse * facing + phong_.specular * fade * std::pow(towards, phong_.shininess);
}

// Bilinear in the cube map whose layout lut.h states.
double Light::looked_up(Vec3 normal) const {
  const std::array<double, 3> n{normal.x, normal.y, normal.z};
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(n[i]) > std::abs(n[axis])) axis = i;
  }
  constexpr int kLast = wire::kReflectanceSize - 1;
  const std::size_t face = 2 * axis + (n[axis] < 0 ? 1 : 0);
  const auto texel = [&](double minor) { return (minor / std::abs(n[axis]) + 1) / 2 * kLast; };
  const double column = texel(n[axis == 0 ? 1 : 0]), row = texel(n[axis == 2 ? 1 : 2]);
  const int i = std::min(static_cast<int>(column), kLast - 1), j = std::min(static_cast<int>(row), kLast - 1);
  const double s = column - i, t = row - j;
  const auto at = [&](int x, int y) {
    return map_[(face * wire::kReflectanceSize + static_cast<std::size_t>(y)) * wire::kReflectanceSize +
                static_cast<std::size_t>(x)] /
           kCoefficientOne;
  };
  return (1 - t) * ((1 - s) * at(i, j) + s * at(i + 1, j)) + t * ((1 - s) * at(i, j + 1) + s * at(i + 1, j + 1));
}

}  // namespace gicube::reference

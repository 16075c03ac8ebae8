#include "light_samples.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

namespace gicube::reference::paths {

namespace {

constexpr double kPi = std::numbers::pi;

double radiance_of(const RectangleLight& light) {
  return light.power / (kPi * length(cross(light.edge_u, light.edge_v)));
}
double radiance_of(const SphereLight& light) { return light.power / (kPi * 4 * kPi * light.radius * light.radius); }

LightSample sample(const PointLight& light, Vec3 position, CounterRandom&) {
  const Vec3 way = light.position - position;
  const double distance = length(way);
  return {1 / distance * way, distance, light.power / (4 * kPi * distance * distance)};
}

LightSample sample(const DirectionalLight& light, Vec3, CounterRandom&) {
  return {normalise(light.towards), std::numeric_limits<double>::infinity(), light.irradiance};
}

LightSample sample(const RectangleLight& light, Vec3 position, CounterRandom& random) {
  const double u = random.uniform(), v = random.uniform();
  const Vec3 way = light.corner + u * light.edge_u + v * light.edge_v - position;
  const double distance = length(way);
  const Vec3 direction = 1 / distance * way, across = cross(light.edge_u, light.edge_v);
  const double facing = -dot(across, direction);  // cosine times area
  return {direction, distance, facing > 0 ? radiance_of(light) * facing / (distance * distance) : 0};
}

// Even over the cone under which the sphere is seen.
LightSample sample(const SphereLight& light, Vec3 position, CounterRandom& random) {
  const Vec3 way = light.centre - position;
  const double squared = dot(way, way), sine_squared = light.radius * light.radius / squared;
  if (!(sine_squared < 1)) return {{0, 0, 1}, 0, 0};
  const double cone = sine_squared / (1 + std::sqrt(1 - sine_squared));  // 1 - cosine of its half angle
  const double cosine = 1 - random.uniform() * cone, turn = 2 * kPi * random.uniform();
  const Vec3 axis = normalise(way);
  const Vec3 across = normalise(cross(axis, std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const Vec3 direction = cosine * axis + sine * std::cos(turn) * across + sine * std::sin(turn) * cross(axis, across);
  const double along = dot(way, direction);
  const double root = std::max(0.0, along * along - squared + light.radius * light.radius);
  return {direction, along - std::sqrt(root), radiance_of(light) * 2 * kPi * cone};
}

std::optional<LightHit> hit(const RectangleLight& light, Vec3 origin, Vec3 direction) {
  const Vec3 normal = cross(light.edge_u, light.edge_v);
  const double towards = dot(normal, direction);
  if (!(towards < 0)) return std::nullopt;
  const double distance = dot(normal, light.corner - origin) / towards;
  if (!(distance > 0)) return std::nullopt;
  const Vec3 met = origin + distance * direction - light.corner;
  const double size = dot(normal, normal);
  const double u = dot(cross(met, light.edge_v), normal) / size, v = dot(cross(light.edge_u, met), normal) / size;
  if (u < 0 || u > 1 || v < 0 || v > 1) return std::nullopt;
  return LightHit{distance, radiance_of(light)};
}

std::optional<LightHit> hit(const SphereLight& light, Vec3 origin, Vec3 direction) {
  const Vec3 way = light.centre - origin;
  const double along = dot(way, direction), outside = dot(way, way) - light.radius * light.radius;
  const double root = along * along - outside;
  if (outside < 0 || along <= 0 || root < 0) return std::nullopt;
  return LightHit{along - std::sqrt(root), radiance_of(light)};
}

template <typename NoArea>
std::optional<LightHit> hit(const NoArea&, Vec3, Vec3) {
  return std::nullopt;
}

}  // namespace

Light to_physical(const Light& light, Vec3 spacing) {
  const auto place = [spacing](Vec3 voxel) {
    return Vec3{voxel.x * spacing.x, voxel.y * spacing.y, voxel.z * spacing.z};
  };
  return std::visit(
      [&](auto made) -> Light {
        using Kind = decltype(made);
        if constexpr (std::is_same_v<Kind, PointLight>) made.position = place(made.position);
        if constexpr (std::is_same_v<Kind, RectangleLight>) made.corner = place(made.corner);
        if constexpr (std::is_same_v<Kind, SphereLight>) made.centre = place(made.centre);
        return made;
      },
      light);
}

LightSample sample_light(const Light& light, Vec3 position, CounterRandom& random) {
  return std::visit([&](const auto& kind) { return sample(kind, position, random); }, light);
}

std::optional<LightHit> hit_light(const Light& light, Vec3 origin, Vec3 direction) {
  return std::visit([&](const auto& kind) { return hit(kind, origin, direction); }, light);
}

}  // namespace gicube::reference::paths

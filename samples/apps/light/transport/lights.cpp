#include "light/transport/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gicube/scene/error.h"

namespace gicube::samples {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

// The share of the sphere that a ball covers, seen from outside of it; 1 from within.
double share_of_sphere(Vec3 from, Vec3 middle, double radius) {
  const Vec3 way = middle - from;
  const double squared = radius * radius / dot(way, way);
  return squared < 1 ? squared / (1 + std::sqrt(1 - squared)) / 2 : 1;
}

}  // namespace

Lights::Lights(const SceneSetup& setup, const Medium& medium) : middle_(medium.middle()), radius_(medium.radius()) {
  double all = 0;
  for (std::size_t i = 0; i < setup.lights.size(); ++i) {
    Light light = setup.lights[i];
    double power = 0;
    if (auto* point = std::get_if<PointLight>(&light)) {
      point->position = medium.place_of(point->position);
      power = point->power * share_of_sphere(point->position, middle_, radius_);
    } else if (auto* distant = std::get_if<DirectionalLight>(&light)) {
      distant->towards = normalise(distant->towards);
      power = distant->irradiance * kHalfTurn * radius_ * radius_;
    } else if (auto* rectangle = std::get_if<RectangleLight>(&light)) {
      rectangle->corner = medium.place_of(rectangle->corner);
      power = rectangle->power;
    } else if (auto* sphere = std::get_if<SphereLight>(&light)) {
      sphere->centre = medium.place_of(sphere->centre);
      power = sphere->power;
    }
    lights_.push_back(light);
    colours_.push_back(setup.light_colours[i]);
    chances_.push_back(power * std::ranges::max(colours_.back()));
    all += chances_.back();
  }
  if (!(all > 0)) throw InputError("light", "at least one", "none");
  for (double& chance : chances_) chance /= all;
}

bool Lights::has_area(std::size_t light) const {
  return std::holds_alternative<RectangleLight>(lights_[light]) || std::holds_alternative<SphereLight>(lights_[light]);
}

double Lights::area(std::size_t light) const {
  if (const auto* rectangle = std::get_if<RectangleLight>(&lights_[light])) {
    return length(cross(rectangle->edge_u, rectangle->edge_v));
  }
  if (const auto* sphere = std::get_if<SphereLight>(&lights_[light]))
    return 4 * kHalfTurn * sphere->radius * sphere->radius;
  return 1;
}

Rgb Lights::power(std::size_t light, double factor) const {
  const auto of = [](const auto& kind) {
    if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, DirectionalLight>)
      return kind.irradiance;
    else
      return kind.power;
  };
  Rgb out = colours_[light];
  for (double& part : out) part *= factor * std::visit(of, lights_[light]);
  return out;
}

LightPoint Lights::point(PathRandom& random) const {
  LightPoint out;
  for (double chance = random.uniform(); out.light + 1 < lights_.size(); ++out.light) {
    chance -= chances_[out.light];
    if (chance < 0) break;
  }
  out.density = chances_[out.light] / area(out.light);
  const Light& light = lights_[out.light];
  if (const auto* at = std::get_if<PointLight>(&light)) {
    out.place = at->position;
  } else if (const auto* distant = std::get_if<DirectionalLight>(&light)) {
    out.place = distant->towards;
  } else if (const auto* rectangle = std::get_if<RectangleLight>(&light)) {
    const double u = random.uniform(), v = random.uniform();
    out.place = rectangle->corner + u * rectangle->edge_u + v * rectangle->edge_v;
    out.normal = normalise(cross(rectangle->edge_u, rectangle->edge_v));
  } else if (const auto* sphere = std::get_if<SphereLight>(&light)) {
    out.normal = random.direction();
    out.place = sphere->centre + sphere->radius * out.normal;
  }
  return out;
}

Rgb Lights::emitted(const LightPoint& point, Vec3 direction) const {
  if (is_distant(point.light)) return power(point.light, 1 / point.density);
  if (!has_area(point.light)) return power(point.light, 1 / (4 * kHalfTurn * point.density));
  return power(point.light,
               std::max(0.0, dot(point.normal, direction)) / (kHalfTurn * area(point.light) * point.density));
}

double Lights::emission_density(const LightPoint& point, Vec3 direction) const {
  if (is_distant(point.light)) return 1 / (kHalfTurn * radius_ * radius_);
  if (has_area(point.light)) return std::max(0.0, dot(point.normal, direction)) / kHalfTurn;
  return 1 / (4 * kHalfTurn * share_of_sphere(point.place, middle_, radius_));
}

Lights::Emission Lights::emit(PathRandom& random) const {
  Emission out{.point = point(random), .place = {}, .direction = {}, .density = 0, .power = {}};
  out.place = out.point.place;
  if (is_distant(out.point.light)) {
    const double ring = radius_ * std::sqrt(random.uniform()), turn = 2 * kHalfTurn * random.uniform();
    out.direction = -1.0 * out.point.place;
    out.place = middle_ + turned({ring * std::cos(turn), ring * std::sin(turn), -radius_}, out.direction);
  } else if (has_area(out.point.light)) {
    const double squared = random.uniform(), turn = 2 * kHalfTurn * random.uniform(), ring = std::sqrt(squared);
    out.direction = turned({ring * std::cos(turn), ring * std::sin(turn), std::sqrt(1 - squared)}, out.point.normal);
  } else {
    const double share = share_of_sphere(out.place, middle_, radius_);
    out.direction = random.direction(share);
    if (share < 1) out.direction = turned(out.direction, normalise(middle_ - out.place));
  }
  out.density = emission_density(out.point, out.direction);
  out.power = emitted(out.point, out.direction);
  for (double& part : out.power) part = out.density > 0 ? part / out.density : 0;
  return out;
}

void Lights::meet(Vec3 place, Vec3 direction,
                  const std::function<void(const LightPoint&, double, const Rgb&)>& found) const {
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const auto tell = [&](double distance, Vec3 normal) {
      const LightPoint point{i, place + distance * direction, normal, chances_[i] / area(i)};
      found(point, distance, power(i, 1 / (kHalfTurn * area(i))));
    };
    if (const auto* rectangle = std::get_if<RectangleLight>(&lights_[i])) {
      const Vec3 across = cross(rectangle->edge_u, rectangle->edge_v);
      const double towards = dot(across, direction), size = dot(across, across);
      const double distance = towards < 0 ? dot(across, rectangle->corner - place) / towards : 0;
      const Vec3 met = place + distance * direction - rectangle->corner;
      const double u = dot(cross(met, rectangle->edge_v), across) / size;
      const double v = dot(cross(rectangle->edge_u, met), across) / size;
      if (distance > 0 && u >= 0 && u <= 1 && v >= 0 && v <= 1) tell(distance, normalise(across));
    } else if (const auto* sphere = std::get_if<SphereLight>(&lights_[i])) {
      const Vec3 way = sphere->centre - place;
      const double along = dot(way, direction), outside = dot(way, way) - sphere->radius * sphere->radius;
      const double root = along * along - outside;
      if (outside < 0 || along <= 0 || root < 0) continue;
      const double distance = along - std::sqrt(root);
      tell(distance, normalise(place + distance * direction - sphere->centre));
    }
  }
}

}  // namespace gicube::samples

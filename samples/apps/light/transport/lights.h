// The lights of a scene as places where paths begin.
#pragma once

#include <functional>
#include <vector>

#include "light/transport/medium.h"

namespace gicube::samples {

// A random point of a light: of a rectangle or a sphere even over its area, of a distant light a direction.
struct LightPoint {
  std::size_t light = 0;
  Vec3 place;          // distant lights: the direction towards them
  Vec3 normal{};       // of an area; zero otherwise
  double density = 0;  // of the choice of the light, times that of the point on its area
};

class Lights {
 public:
  // Throws InputError: no light.
  Lights(const SceneSetup& setup, const Medium& medium);

  bool has_area(std::size_t light) const;
  bool is_distant(std::size_t light) const { return std::holds_alternative<DirectionalLight>(lights_[light]); }
  LightPoint point(PathRandom& random) const;
  // Power per solid angle along `direction` (unit, from the light) over the point's density: radiance times the cosine
  // for areas; distant lights: irradiance across the direction.
  Rgb emitted(const LightPoint& point, Vec3 direction) const;

  // A ray from a light into the volume's surroundings, by its power.
  struct Emission {
    LightPoint point;
    Vec3 place, direction;
    double density = 0;  // of the direction, per solid angle; distant lights: of the place, per area across the ray
    Rgb power;           // over all densities
  };
  Emission emit(PathRandom& random) const;
  double emission_density(const LightPoint& point, Vec3 direction) const;

  // Calls `found` for each area light that shines against the ray, with the point that it meets and the light's
  // radiance.
  void meet(Vec3 place, Vec3 direction,
            const std::function<void(const LightPoint&, double distance, const Rgb&)>& found) const;

 private:
  double area(std::size_t light) const;  // 1 for those without
  Rgb power(std::size_t light, double factor) const;

  std::vector<Light> lights_;  // physical
  std::vector<Rgb> colours_;
  std::vector<double> chances_;  // by the power that reaches the volume's surroundings
  Vec3 middle_;
  double radius_;
};

}  // namespace gicube::samples

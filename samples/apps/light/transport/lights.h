// The lights of a scene, at which paths begin.
#pragma once

#include <functional>
#include <vector>

#include "light/transport/medium.h"

namespace gicube::samples {

// A random point of a light: uniform over the area of a rectangle or a sphere; of a distant light, a direction.
struct LightPoint {
  std::size_t light = 0;
  Vec3 place;          // distant lights: the direction towards them
  Vec3 normal{};       // of an area light; zero otherwise
  double density = 0;  // probability of the light, times the density of the point on its area
};

class Lights {
 public:
  // Throws InputError: no light.
  Lights(const SceneSetup& setup, const Medium& medium);

  bool has_area(std::size_t light) const;
  bool is_distant(std::size_t light) const { return std::holds_alternative<DirectionalLight>(lights_[light]); }
  LightPoint point(PathRandom& random) const;
  // Power per solid angle along `direction` (unit, from the light), divided by the point's density: for area lights
  // radiance times the cosine; for distant lights the irradiance across the direction.
  Rgb emitted(const LightPoint& point, Vec3 direction) const;

  // A ray from a light towards the volume's bounding sphere.
  struct Emission {
    LightPoint point;
    Vec3 place, direction;
    double density = 0;  // of the direction, per solid angle; distant lights: of the place, per area across the ray
    Rgb power;           // divided by all densities
  };
  Emission emit(PathRandom& random) const;
  double emission_density(const LightPoint& point, Vec3 direction) const;

  // Calls `found` for each area light that the ray hits from its front, with the point and the light's radiance.
  void meet(Vec3 place, Vec3 direction,
            const std::function<void(const LightPoint&, double distance, const Rgb&)>& found) const;

 private:
  double area(std::size_t light) const;  // 1 for those without
  Rgb power(std::size_t light, double factor) const;

  std::vector<Light> lights_;  // physical
  std::vector<Rgb> colours_;
  std::vector<double> chances_;  // probabilities of the lights, by their power towards the volume's bounding sphere
  Vec3 middle_;
  double radius_;
};

}  // namespace gicube::samples

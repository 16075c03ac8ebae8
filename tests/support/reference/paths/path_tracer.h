// A volumetric path tracer in double precision: the light of a scene without bias, what the board's light is judged by.
//
// A path goes from the eye from collision to collision (extinction.h), at each of which it is connected with every
// light and scattered. It plays Russian roulette, so its length has no bound but PathScene::max_scatterings. A radiance
// of L shows a white surface on which L pi of power falls on a unit of area.
#pragma once

#include <cstdint>
#include <vector>

#include "extinction.h"
#include "light_guide.h"
#include "path_scene.h"
#include "reference/camera.h"
#include "reference/photons.h"

namespace gicube::reference::paths {

struct RadiancePicture {
  int width = 0, height = 0;
  std::vector<std::array<Estimate, 3>> pixels;  // rows from the top

  const std::array<Estimate, 3>& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

class PathTracer {
 public:
  // The scene must outlive it. Throws std::invalid_argument for a routine that the board does not have built in, and
  // unless there is a colour for each light. `guided`: for seconds of preparation paths find lamps behind mirrors and
  // glass more often.
  explicit PathTracer(const PathScene& scene, bool guided = false);

  // Of one path that begins at `origin` (voxels, anywhere) along `direction` (physical, any length but 0).
  Rgb radiance(Vec3 origin, Vec3 direction, CounterRandom& random) const;
  // Mean of `paths` of them and its standard error. Each path has a stream of its own.
  std::array<Estimate, 3> estimate(Vec3 origin, Vec3 direction, std::uint64_t paths, std::uint64_t seed) const;
  // Paths begin evenly within each pixel. `threads`: 0 = as many as the machine has; the picture does not depend on it.
  RadiancePicture render(std::uint64_t paths_per_pixel, std::uint64_t seed, unsigned threads = 2) const;

  const Extinction& extinction() const { return extinction_; }

 private:
  Vec3 normal_at(const Collision& collision, Vec3 direction, bool& enters, bool& flat) const;
  void add_connections(Rgb& sum, const Rgb& weight, const Collision& collision, const Flight& flight, Vec3 normal,
                       CounterRandom& random) const;
  void add_seen_lights(Rgb& sum, const Rgb& weight, const Flight& flight, double reach, double most) const;

  const PathScene& scene_;
  Field field_;
  Extinction extinction_;
  // A direction to go on, 0 if nothing does; `weight` is what the choice leaves of the path's.
  Vec3 go_on(const Material& material, const Collision& collision, Vec3 direction, Vec3 normal, Rgb& weight,
             CounterRandom& random) const;

  std::vector<Light> lights_;  // physical
  std::optional<LightGuide> guide_;
};

}  // namespace gicube::reference::paths

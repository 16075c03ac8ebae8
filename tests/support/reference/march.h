// A plain, slow ray march in double precision of the scene that a board renders: what its fixed-point pictures are held
// against. It shares no arithmetic with the board; with quantisers it repeats the board's roundings, each by itself.
//
// A ray is sampled where it enters the kept part of the volume (or at the eye) and then every `step` voxels, until it
// leaves or its opacity has reached the threshold. A sample of opacity a stands for step |spacing o direction| smallest
// voxel edges: 1 - (1 - a)^that. A picture's pixels are its rays under the view's filter.
#pragma once

#include "camera.h"
#include "field.h"
#include "light.h"
#include "scene.h"

namespace gicube::reference {

class Renderer {
 public:
  explicit Renderer(const Scene& scene, const Quantisers& quantisers = {});

  // Integrates one ray: `origin` in voxels, anywhere; `direction` in voxels, any length but 0.
  Rgba integrate(Vec3 origin, Vec3 direction) const;

  // `threads`: how many may work at once, 0 = as many as the machine has; the picture does not depend on it.
  Picture render(unsigned threads = 0) const;

  const Field& field() const { return field_; }
  const Camera& camera() const { return camera_; }

 private:
  Rgba march(const Line& line, Interval interval) const;
  Rgba march_in_words(const Line& line, Interval interval) const;
  // Puts the sample at `position` behind what `ray` has gathered; it stands for `edges` smallest voxel edges.
  void add_sample(Rgba& ray, Vec3 position, Vec3 direction, double edges) const;
  double edges_per_step(Vec3 direction) const;

  Scene scene_;
  Quantisers quantisers_;
  double step_;  // voxels
  Field field_;
  Camera camera_;
  Light light_;
};

inline Picture render(const Scene& scene, const Quantisers& quantisers = {}) {
  return Renderer(scene, quantisers).render();
}

}  // namespace gicube::reference

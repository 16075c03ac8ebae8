// The pieces of volumes between surfaces along a viewing ray, in order, and their compositing.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "gicube/vector.h"

namespace gicube::samples {

// Colour premultiplied by opacity, display-referred, each 0..1.
struct Premultiplied {
  std::array<double, 3> colour{};
  double opacity = 0;

  friend bool operator==(const Premultiplied&, const Premultiplied&) = default;
};

// A straight part of a ray in a volume: at a distance from the eye, near..far, it is at origin + distance * direction,
// in voxels.
struct Span {
  std::size_t volume = 0;
  double near = 0, far = 0;
  Vec3 origin, direction;
  double shade = 1;  // of its light, 0..1

  Vec3 at(double distance) const { return origin + distance * direction; }
};

struct SurfacePoint {
  double distance = 0;
  Premultiplied look;
};

// To be traced by the volume's board, in voxels.
struct PlannedSegment {
  std::size_t volume = 0;
  Vec3 from, to;
  double shade = 1;
};

// A surface, or segments that fill the same piece of the ray.
struct Layer {
  std::size_t segments = 0;  // 0: a surface
  Premultiplied surface;
};

struct RayPlan {
  std::vector<PlannedSegment> segments;  // in the order of the layers
  std::vector<Layer> layers;             // front to back
};

// Cuts the spans at each other's ends and at the surfaces (by distance). Where several volumes overlap, the ray is cut
// into pieces of at most `overlap_step` voxels, by the finest. What is behind an opaque surface is left out.
void plan_ray(std::span<const Span> spans, std::span<const SurfacePoint> surfaces, double overlap_step, RayPlan& plan);

// Media that fill the same piece, each uniform in it: the transmittance is the product of theirs, and each has the
// share in the light that it has in the optical depth. Exact for uniform media. Opaque ones hide all others, and share
// equally.
Premultiplied mixed(std::span<const Premultiplied> media);

// `behind` seen through `front`.
Premultiplied over(const Premultiplied& front, const Premultiplied& behind);

}  // namespace gicube::samples

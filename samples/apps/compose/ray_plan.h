// Ordered pieces of volumes between surfaces along a viewing ray, and their compositing.
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

// A straight part of a ray in a volume: at a distance near..far from the eye, its place is origin + distance *
// direction, in voxels.
struct Span {
  std::size_t volume = 0;
  double near = 0, far = 0;
  Vec3 origin, direction;
  double shade = 1;  // factor of its light, 0..1

  Vec3 at(double distance) const { return origin + distance * direction; }
};

struct SurfacePoint {
  double distance = 0;
  Premultiplied look;
};

// Segment for the volume's board, in voxels.
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

// Divides the spans at each other's ends and at the surfaces (sorted by distance). Divides overlaps of volumes into
// pieces of at most `overlap_step` voxels of the finest one. Omits pieces behind an opaque surface.
void plan_ray(std::span<const Span> spans, std::span<const SurfacePoint> surfaces, double overlap_step, RayPlan& plan);

// Mixes media in the same piece: the transmittance is the product of theirs, and the share of each in the light is its
// share of the optical depth. Exact for uniform media. Opaque media hide all others, and have equal shares.
Premultiplied mixed(std::span<const Premultiplied> media);

// Composites `front` over `behind`.
Premultiplied over(const Premultiplied& front, const Premultiplied& behind);

}  // namespace gicube::samples

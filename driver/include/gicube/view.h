// A view: camera, image, sampling.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gicube/illumination.h"
#include "gicube/transfer_function.h"
#include "gicube/vector.h"

namespace gicube {

// Points p, in voxels, with normal . p >= offset are kept.
struct CutPlane {
  Vec3 normal;  // any length but 0
  double offset = 0;
};

// A lamp that scattered rays see where they leave the volume, as in a mirror: a RectangleLight, from the side to which
// it shines, or a SphereLight, from outside. It is as bright as a white surface lit by its full power: power / area x
// exposure, of the view or the automatic one (without View::irradiance and without an exposure: x 1), times `colour`.
// It lights nothing: illuminate() does.
struct Lamp {
  Light light = SphereLight{};
  Colour colour{1, 1, 1};  // not below 0
};
inline constexpr std::size_t kMaxLamps = 32;

enum class PixelFilter { kBox, kTent };

// All positions in voxels of the volume; voxel (0, 0, 0) has its centre at the origin. Angles and lengths are seen in
// physical space, so a volume with anisotropic spacing keeps its shape.
//
// Irradiance is what voxels absorbed after illuminate() and rays of type kDeposit: a sample's brightness is then its
// word over (opacity (1 - Ks)). A field that an application wrote, such as a solution of radiosity, is shown as colour
// x irradiance x exposure with `incident`; nothing chooses its exposure.
struct View {
  Vec3 eye{};
  Vec3 look_at{};                  // not at the eye
  Vec3 up{0, 1, 0};                // not along the line of sight
  double fov_degrees = 30;         // vertical, 0..180 exclusive; perspective only
  double orthographic_height = 0;  // > 0: orthographic, the image's height in (smallest) voxel edges
  int width = 512;                 // pixels, 1..4095
  int height = 512;
  int samples_per_axis = 1;  // 1, 2 or 4: rays per pixel are its square
  PixelFilter filter = PixelFilter::kBox;

  // Voxels along the ray, 1/64..16, kept to 16 fraction bits. Without BoardInfo::wide each step is rounded to 2^-14
  // voxel on every axis: steps with which positions could drift by more than a voxel over the volume are refused.
  double step = 0.5;
  double opacity_threshold = 0.98;  // 0..1: a ray at or above it is done
  bool shade = true;
  bool jitter = false;
  bool leap = true;          // over blocks whose empty flag is set
  bool irradiance = false;   // lit by the irradiance that illuminate() left, instead of by the reflectance map
  bool incident = false;     // the irradiance is what falls on a sample, not what it absorbed
  double exposure = 0;       // irradiance only: brightness of one unit of irradiance; 0 = chosen by illuminate()
  bool scatter = false;      // rays continue where a material scatters them (Material::seen_through_scattering)
  bool high_albedo = false;  // colour is taken once, where the ray is absorbed: needs many rays per pixel
  int lifetime = 8;          // scatterings until a ray is given up, 0..1023
  std::uint32_t seed = 0;    // of the scatterings' random choices
  std::vector<CutPlane> cut_planes{};  // at most 6
  // With `scatter`: a ray that was scattered and leaves the volume, or by a cut plane, takes the light of the nearest
  // in its way, times what it still lets through, and the pixel is opaque there. Rays straight from the eye see none,
  // and nothing is seen of a lamp that is inside the volume. At most kMaxLamps; needs a board of protocol 2.3.
  std::vector<Lamp> lamps{};
};

}  // namespace gicube

// The volume into which a scene's solids are voxelised.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/formats/volume_file.h"

namespace gicube::samples {

// Where the voxels lie in the world: cubes, voxel 0's centre at `low`.
struct WorldGrid {
  Vec3 low;
  double voxel = 1;  // edge, world units
  Dims dims{};

  Vec3 voxel_of(Vec3 p) const { return (1 / voxel) * (p - low); }
  Vec3 point_of(Vec3 v) const { return low + voxel * v; }
};

// All three x fastest. Densities are kUint12: kMaxDensity in a solid, linear over kRampVoxels across its surface.
struct VoxelWorld {
  Volume volume;
  std::vector<std::uint8_t> tags;
  std::vector<float> gradients;  // towards growing density, unit length; zero far from all surfaces
};

constexpr double kMaxDensity = 4095;  // of kUint12
constexpr double kRampVoxels = 2;     // chosen: wide enough for trilinear interpolation to follow the surface
// Trilinear samples with a density above zero touch voxels up to ramp/2 + sqrt(3) voxels away: these need tag and normal.
constexpr double kNearVoxels = 3;
// chosen: of a fog's own density, in full scales. Low, so that from fog into a solid the density still rises to the solid's.
constexpr double kFogDensity = 0.25;

}  // namespace gicube::samples

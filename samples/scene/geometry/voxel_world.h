// The volume into which a scene's solids are voxelised.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "scene/formats/volume_file.h"
#include "scene/parallel.h"

namespace gicube::samples {

// Where the voxels lie in the world: cubes, voxel 0's centre at `low`.
struct WorldGrid {
  Vec3 low;
  double voxel = 1;  // edge, world units
  Dims dims{};

  Vec3 voxel_of(Vec3 p) const { return (1 / voxel) * (p - low); }
  Vec3 point_of(Vec3 v) const { return low + voxel * v; }
};

constexpr double kMaxDensity = 4095;  // of kUint12
constexpr double kRampVoxels = 2;     // chosen: wide enough for trilinear interpolation to follow the surface
// Trilinear samples with a density above zero touch voxels up to ramp/2 + sqrt(3) voxels away: these need tag and normal.
constexpr double kNearVoxels = 3;
// chosen: of a fog's own density, in full scales. Low, so that from fog into a solid the density still rises to the solid's.
constexpr double kFogDensity = 0.25;

// All three x fastest. Densities are kUint12: kMaxDensity in a solid, linear over kRampVoxels across its surface.
struct VoxelWorld {
  Volume volume;
  std::vector<std::uint8_t> tags;
  std::vector<float>
      gradients;  // towards growing density, unit length; zero far from all surfaces; empty if not asked for

  VoxelWorld() = default;
  VoxelWorld(const Dims& dims, const char* source, bool with_gradients) {
    const std::size_t voxels = voxels_of(dims);
    volume.type = SampleType::kUint12;
    volume.dims = dims;
    volume.source = source;
    volume.samples.resize(voxels * bytes_per_sample(SampleType::kUint12));
    tags.resize(voxels);
    if (with_gradients) gradients.resize(voxels * 3);
  }

  // `density`: 0..1.
  void set_density(std::size_t index, double density) {
    const auto word = static_cast<std::uint16_t>(std::lround(kMaxDensity * density));
    std::memcpy(&volume.samples[2 * index], &word, sizeof word);
  }
  void set_gradient(std::size_t index, Vec3 g) {
    float* gradient = &gradients[3 * index];
    gradient[0] = static_cast<float>(g.x), gradient[1] = static_cast<float>(g.y), gradient[2] = static_cast<float>(g.z);
  }
};

constexpr int kCell = 8;  // voxels; solids are looked up a cell at a time

inline Vec3 middle_of_cell(const Dims& first) {
  return Vec3{double(first[0]), double(first[1]), double(first[2])} + 0.5 * (kCell - 1) * Vec3{1, 1, 1};
}

// Calls fill(first) for each cell's first voxel, on so many threads (0 = one a core).
template <typename Fill>
void each_cell(const Dims& dims, int threads, const Fill& fill) {
  in_parallel(static_cast<std::size_t>((dims[2] + kCell - 1) / kCell), threads, [&](std::size_t layer) {
    for (int y = 0; y < dims[1]; y += kCell) {
      for (int x = 0; x < dims[0]; x += kCell) fill(Dims{x, y, static_cast<int>(layer) * kCell});
    }
  });
}

// Calls visit(p, index) for each of a cell's voxels.
template <typename Visit>
void each_voxel(const Dims& dims, const Dims& first, const Visit& visit) {
  const auto across = static_cast<std::size_t>(dims[0]), down = static_cast<std::size_t>(dims[1]);
  for (int z = first[2]; z < std::min(first[2] + kCell, dims[2]); ++z) {
    for (int y = first[1]; y < std::min(first[1] + kCell, dims[1]); ++y) {
      const std::size_t row = (static_cast<std::size_t>(z) * down + static_cast<std::size_t>(y)) * across;
      for (int x = first[0]; x < std::min(first[0] + kCell, dims[0]); ++x) {
        visit(Vec3{double(x), double(y), double(z)}, row + static_cast<std::size_t>(x));
      }
    }
  }
}

}  // namespace gicube::samples

// Solids, participating media and scans become densities, tags and normals of one volume.
//
// Content of a voxel where several objects overlap:
//   solids  their union makes density and normal: the nearest surface. The tag is that of the last solid in the list
//           whose inside holds the voxel's centre, otherwise of the nearest.
//   fogs    fill the space that solids leave, whatever the order; of two fogs the later one. Its density is
//           VoxelWorld::fog_density. Voxels whose samples show a solid show no fog, and the fog nearest to them is
//           denser by the missing amount.
//   scans   leave the space of solids, and displace fogs where they are visible; of two the later.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "gicube/scene/affine.h"
#include "gicube/scene/shape.h"
#include "gicube/scene/volume_file.h"

namespace gicube::scene {

// Where the voxels lie in the world: cubes, voxel 0's centre at `low`.
struct WorldGrid {
  Vec3 low;
  double voxel = 1;  // edge, world units
  Dims dims{};

  Vec3 voxel_of(Vec3 p) const { return (1 / voxel) * (p - low); }
  Vec3 point_of(Vec3 v) const { return low + voxel * v; }
};

constexpr double kMaxDensity = 4095;  // of kUint12
// chosen: wide enough for trilinear interpolation to follow the surface.
//
// Such densities are for pictures. They add up to a solid's volume only where its surface is flat and the solid thicker
// than the ramp: a ball of radius r, and a hollow likewise, gets 1 / r^2 more (11% at 3 voxels, 1% at 10), a plate of
// thickness t below 2 gets (1 + t / 2)^2 / 2 in place of t on average of its places (at 0.8: 0.98).
// Densities::kPartialVolumes is for sums and line integrals.
constexpr double kRampVoxels = 2;
// Trilinear samples with a density above zero touch voxels up to ramp/2 + sqrt(3) voxels away: these need tag and
// normal.
constexpr double kNearVoxels = 3;
// chosen: of a fog's own density, in full scales. Low, so that between fog and a solid the surface lies where the
// solid has it.
constexpr double kFogDensity = 0.25;
constexpr double kFogBesideSolids = 0.1;  // chosen: in a volume where solids stand in fog, some of which is then denser

// Densities of voxels at the surfaces of solids. Fogs always have the ramp.
enum class Densities {
  kRamp,            // linear over kRampVoxels of the distance
  kPartialVolumes,  // the share of the voxel's cube that is within them, by 4 x 4 x 4 parts
};

// All three x fastest. Densities are kUint12: kMaxDensity in a solid, and across its surface as Densities says.
struct VoxelWorld {
  Volume volume;
  std::vector<std::uint8_t> tags;
  std::vector<float>
      gradients;  // towards growing density, unit length; zero far from all surfaces; empty if not asked for
  double fog_density = kFogDensity;  // of a fog as its material says, in full scales; or kFogBesideSolids

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

struct PlacedSolid {
  Field field;
  Affine to_voxels;  // from the field's space
  std::uint8_t tag = 0;
  bool fog = false;
};

// At a voxel position: density in full scales, 0..1, or below 0 where the scan has nothing.
using ScanField = std::function<double(Vec3)>;

struct PlacedScan {
  ScanField density;
  Vec3 low, high;  // the box, in voxels, outside of which it has nothing
  std::uint8_t tag = 0;
  double visible = 0;  // from this density on its transfer function shows something
};

// The scan's space: its physical box around the origin, the longest edge 1 long.
GICUBE_API Affine scan_space(const Volume& scan);  // from the scan's voxels

// `to_voxels`: from the scan's space to the world's voxels. Values become densities by `range`. A scan that is finer
// than the world is first averaged over cubes of its voxels; between voxels it is interpolated trilinearly.
// The result has its own copy of the samples. `tag` and `visible` are left to the caller.
GICUBE_API PlacedScan place_scan(const Volume& scan, const ValueRange& range, const Affine& to_voxels);

// Places a density that a function has at each of the world's voxels: from 0 to 1, or below 0 where there is nothing.
// It is called once for each voxel, on several threads (0: one per core).
GICUBE_API PlacedScan place_density(const Dims& dims, const ScanField& density, int threads = 0);

// The voxels do not depend on the number of threads (0 = one per core). Distances are evaluated near surfaces only.
// Under a map that scales unequally the nearest point of a surface is searched for, which takes about thirty
// evaluations of the field per voxel instead of one.
GICUBE_API VoxelWorld voxelise(const WorldGrid& grid, const std::vector<PlacedSolid>& solids,
                               const std::vector<PlacedScan>& scans = {}, int threads = 0,
                               Densities densities = Densities::kRamp);

constexpr std::size_t kCodes = 2048;  // of a gradient codebook, with the zero vector

// A gradient codebook made for one volume: vector quantisation of its own normals, as [P §2.1] suggests. Reflections
// show an error of a normal twice, and the board's own codebook has up to 3.35 degrees of it.
// `gradients`: three floats each, as VolumeView::gradients. The result is for Board::set_gradient_codebook(): code 0 is
// the zero vector, the others are unit vectors; as many as there are different directions, at most 2047. Chosen so that
// the farthest direction is near (farthest-point choice), then moved to the means of what they stand for (Lloyd).
GICUBE_API std::vector<Vec3> codebook_of(std::span<const float> gradients);

}  // namespace gicube::scene

// Voxelisation of solids, participating media and scans to densities, tags and normals of one volume.
//
// Content of a voxel where several objects overlap:
//   solids  their union gives density and normal, by the nearest surface. The tag is that of the last solid in the list
//           that contains the voxel's centre, otherwise of the nearest solid.
//   fogs    fill the space outside solids, whatever the order; the later of two fogs wins. The density is
//           VoxelWorld::fog_density. Voxels whose samples show a solid show no fog, and the nearest fog is denser by
//           the missing amount.
//   scans   do not change solids, and replace fogs where they are visible; the later of two scans wins.
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

// The position of the voxels in the world. Voxels are cubes, and the centre of voxel 0 is at `low`.
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
// Such densities are for pictures. Their sum is a solid's volume only where the surface is flat and the solid thicker
// than the ramp: a ball of radius r, or a hollow, gets 1 / r^2 more (11% at 3 voxels, 1% at 10), and a plate of
// thickness t below 2 gets (1 + t / 2)^2 / 2 instead of t, averaged over its positions (0.98 for 0.8). For sums and
// line integrals use Densities::kPartialVolumes.
constexpr double kRampVoxels = 2;
// Trilinear samples with a density above zero use voxels up to ramp/2 + sqrt(3) voxels from the surface, which
// therefore need tag and normal.
constexpr double kNearVoxels = 3;
// chosen: a fog's density, in full scales. It is low, so that the interpolated surface between fog and a solid is that
// of the solid.
constexpr double kFogDensity = 0.25;
constexpr double kFogBesideSolids = 0.1;  // chosen: in a volume with solids in fog, some of which is then denser

// Densities of voxels at the surfaces of solids. Fogs always have the ramp.
enum class Densities {
  kRamp,            // linear over kRampVoxels of the distance
  kPartialVolumes,  // the share of the voxel's cube that is within them, by 4 x 4 x 4 parts
};

// All three have x fastest. Densities are kUint12: kMaxDensity in a solid, and across its surface as Densities defines.
struct VoxelWorld {
  Volume volume;
  std::vector<std::uint8_t> tags;
  // Unit vectors towards increasing density; zero far from all surfaces; empty unless requested.
  std::vector<float> gradients;
  double fog_density = kFogDensity;  // in full scales, for the extinction of its material; or kFogBesideSolids

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
  Vec3 low, high;  // its box, in voxels
  std::uint8_t tag = 0;
  double visible = 0;  // the least density that its transfer function makes visible
};

// The map from a scan's voxels to its own space, in which its physical box is centred on the origin and its longest
// edge is 1 long.
GICUBE_API Affine scan_space(const Volume& scan);

// `to_voxels` maps the scan's space to the world's voxels; `range` maps values to densities. A scan that is finer than
// the world is first averaged over cubes of its voxels, and then interpolated trilinearly. The result has its own copy
// of the samples. The caller sets `tag` and `visible`.
GICUBE_API PlacedScan place_scan(const Volume& scan, const ValueRange& range, const Affine& to_voxels);

// Places the densities that a function gives for each of the world's voxels: from 0 to 1, or below 0 where there is
// nothing. It is called once for each voxel, on several threads (0: one per core).
GICUBE_API PlacedScan place_density(const Dims& dims, const ScanField& density, int threads = 0);

// The voxels do not depend on the number of threads (0 = one per core). Distances are evaluated near surfaces only.
// Under a map that scales unequally the nearest point of a surface is searched for, which takes about thirty
// evaluations of the field per voxel instead of one.
GICUBE_API VoxelWorld voxelise(const WorldGrid& grid, const std::vector<PlacedSolid>& solids,
                               const std::vector<PlacedScan>& scans = {}, int threads = 0,
                               Densities densities = Densities::kRamp);

constexpr std::size_t kCodes = 2048;  // of a gradient codebook, with the zero vector

// A gradient codebook for one volume: vector quantisation of its normals, as [P §2.1] suggests. Reflections double the
// error of a normal, which is up to 3.35 degrees with the board's own codebook. `gradients`: three floats each, like
// VolumeView::gradients. The result is for Board::set_gradient_codebook(): code 0 is the zero vector, the others are
// unit vectors, as many as there are different directions, at most 2047. They are chosen by farthest-point sampling,
// then moved to the means of the directions that they encode (Lloyd).
GICUBE_API std::vector<Vec3> codebook_of(std::span<const float> gradients);

}  // namespace gicube::scene

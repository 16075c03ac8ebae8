// Solids, participating media and scans become densities, tags and normals of one volume.
//
// What a voxel holds where several overlap:
//   solids  their union makes density and normal: the nearest surface. The tag is that of the last solid in the list whose
//           inside holds the voxel's centre, or else of the nearest.
//   fogs    fill what solids leave free, whatever the order; of two fogs the later one. Its density is kFogDensity.
//   scans   leave to solids what these fill, and take from fogs where they themselves are visible; of two the later.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "scene/geometry/affine.h"
#include "scene/geometry/shape.h"
#include "scene/geometry/voxel_world.h"

namespace gicube::samples {

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
Affine scan_space(const Volume& scan);  // from the scan's voxels

// `to_voxels`: from the scan's space to the world's voxels. Values become densities by `range`. A scan that is finer than
// the world is first averaged over cubes of its voxels; between voxels it is interpolated trilinearly.
// The result has its own copy of the samples. `tag` and `visible` are left to the caller.
PlacedScan place_scan(const Volume& scan, const ValueRange& range, const Affine& to_voxels);

// The same voxels for any number of threads (0 = one a core). Distances are evaluated near surfaces only.
VoxelWorld voxelise(const WorldGrid& grid, const std::vector<PlacedSolid>& solids,
                    const std::vector<PlacedScan>& scans = {}, int threads = 0);

}  // namespace gicube::samples

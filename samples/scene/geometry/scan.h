// A scanned volume as a field that can be placed anywhere in a world.
#pragma once

#include "scene/formats/volume_file.h"
#include "scene/geometry/affine.h"
#include "scene/geometry/voxeliser.h"

namespace gicube::samples {

// The scan's space: its physical box around the origin, the longest edge 1 long.
Affine scan_space(const Volume& scan);  // from the scan's voxels

// `to_voxels`: from the scan's space to the world's voxels. Values become densities by `range`. A scan that is finer than
// the world is first averaged over cubes of its voxels; between voxels it is interpolated trilinearly.
// The result has its own copy of the samples. `tag` and `visible` are left to the caller.
PlacedScan place_scan(const Volume& scan, const ValueRange& range, const Affine& to_voxels);

}  // namespace gicube::samples

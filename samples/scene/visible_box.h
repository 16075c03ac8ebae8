// Where a volume shows anything at all: most scans are mostly air.
#pragma once

#include "scene/formats/volume_file.h"
#include "scene/transfer_function_file.h"

namespace gicube::samples {

// Voxels, both ends included.
struct VoxelBox {
  Vec3 low, high;
};

VoxelBox whole_box(const Dims& dims);

// The volume's own range, or else the driver's default for its type (VolumeView::range). Not-a-numbers are left out.
ValueRange value_range_of(const Volume& volume);

// The smallest box around all voxels that the function makes visible, one voxel of margin included; the whole volume if
// none is. `volume` must hold all samples of its dims.
VoxelBox visible_box(const Volume& volume, const TransferFunctionFile& file);

}  // namespace gicube::samples

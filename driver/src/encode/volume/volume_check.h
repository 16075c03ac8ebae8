// Whether a volume can go to the board at all, and the map from its values to densities.
#pragma once

#include "gicube/volume.h"

namespace gicube {

// Throws BadArgument naming the field, and the first voxel where a sample, gradient or tag is wrong.
// `max_volume_voxels`: the board's largest volume edge N.
void check_volume(const VolumeView& view, int max_volume_voxels);

// The view's own range, or the default that volume.h states. Only for a view that passed check_volume().
// A constant volume of value v, which has no span of its own, gets v .. v + 1.
ValueRange resolve_range(const VolumeView& view);

// The voxel edges over the smallest of them: 1..64 each.
Vec3 relative_spacing(Vec3 spacing);

}  // namespace gicube

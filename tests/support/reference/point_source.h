// The energy that a point source leaves in an absorber: kappa e^(-kappa r) / (4 pi r^2) of its energy a volume.
#pragma once

#include <functional>

#include "gicube/vector.h"

namespace gicube::reference {

double absorbed_density(double kappa, double r);

// The share of the energy that falls to a voxel when every bit of it is spread trilinearly where it is absorbed: the
// density's integral, weighted by the voxel's tent, which reaches one voxel to each side. Cubes of edge 1; `source` and
// `voxel` in voxels, `kappa` a voxel. To 1e-6, wherever the source lies. `low` and `high` bound the medium.
double absorbed_by_voxel(double kappa, Vec3 source, Vec3 voxel, Vec3 low, Vec3 high);

}  // namespace gicube::reference

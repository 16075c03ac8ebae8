// Line integrals of a volume, their transpose and conjugate gradients on both in double precision, for judging
// gicube::Projector and what is built on it. Plain and slow: a ray is sampled a hundred times a voxel between where it
// enters and leaves the box of voxel centres. Of the driver it takes the records alone.
#pragma once

#include <vector>

#include "gicube/projector.h"

namespace gicube::reference {

// The exact results of Projector::project() and backproject() of all views.
std::vector<double> project(const ProjectorSetup& setup, const std::vector<double>& volume);
std::vector<double> backproject(const ProjectorSetup& setup, const std::vector<double>& values);

// So many iterations of conjugate gradients (Hestenes and Stiefel 1952) from nothing.
std::vector<double> cgls(const ProjectorSetup& setup, const std::vector<double>& measured, int iterations);

}  // namespace gicube::reference

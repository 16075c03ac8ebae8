// Converts a radiosity solution to the incident light of a volume's voxels, for pictures.
#pragma once

#include <vector>

#include "form_factors/radiosity/radiosity.h"
#include "gicube/scene/light_field.h"
#include "scene/names.h"

namespace gicube::samples {

// A solution's incident light is constant on each cluster at the end of a link, so pictures would show the clusters'
// edges. This function diffuses light between neighbouring elements of one facing, over the widths of the clusters that
// received it: sigma is a third of their width, weighted by their light. The sum over all elements stays the same.
std::vector<Power> smoothed(const RadiosityResult& result);

// Returns three channels.
//  - Solid surfaces have the power of the faces nearby over their true area, the sum of area x (normal . axis) with the
//    surface's normal (Gauss's theorem). A staircase of voxel faces is larger than its surface, and would be too dark.
//    One or two layers of voxels have this light: those that a picture's samples touch.
//  - Medium has its own incident light.
//  - Emitted light is added, so that an emitter shows its colour times its emission.
// Normals are the setup's gradients or, without these, those of the faces nearby.
LightField field_of(const RadiosityResult& result, const SceneSetup& setup);

}  // namespace gicube::samples

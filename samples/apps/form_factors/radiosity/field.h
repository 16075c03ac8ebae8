// A solution of radiosity as the light that falls on a volume's voxels, ready for pictures.
#pragma once

#include <vector>

#include "form_factors/radiosity/radiosity.h"
#include "gicube/scene/light_field.h"
#include "scene/names.h"

namespace gicube::samples {

// A solution's incident light is the same all over each cluster that a link ends at, so that pictures show its edges.
// Here light flows between neighbouring elements of one facing, as heat does, as far as the clusters are wide that it
// came by: sigma is a third of their width, weighted by what each brought. What falls on all elements together stays as
// it is.
std::vector<Power> smoothed(const RadiosityResult& result);

// Three channels. Where there is
//  - a solid's surface: the power that its faces get around there over the true area that they stand for, which is the
//    sum of area x (normal . axis) by the surface's own normal (Gauss's theorem): a staircase of voxel faces is larger
//    than the surface that it follows, and would be too dark. Of layers of voxels that a picture's samples touch, one
//    to two deep;
//  - medium: its own incident light;
//  - light of its own: that too, as if it fell there, so that an emitter shows its colour times what it sends out.
// Normals are the setup's gradients; where it has none, those of the faces around.
LightField field_of(const RadiosityResult& result, const SceneSetup& setup);

}  // namespace gicube::samples

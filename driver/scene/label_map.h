// Label maps and masks as volumes that a board can show.
#pragma once

#include "gicube/scene/scene.h"

namespace gicube::scene {

// Replaces the samples, whose values are labels, by 255 where there is one, and tags the voxels, so that each of the
// board's four materials has a colour: up to four labels one each, more of them so that those that touch differ where
// four colours allow it. Labels that enclose others are translucent. A volume that is read in planes stays as it is.
// Adds the colours to `look_why`.
void colour_labels(SceneSetup& setup);

}  // namespace gicube::scene

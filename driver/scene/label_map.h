// Conversion of label maps and masks to volumes for the board.
#pragma once

#include "gicube/scene/scene.h"

namespace gicube::scene {

// Replaces labels, the values of the samples, by 255, and tags the voxels, so that each of the board's four materials
// has a colour: up to four labels have one each; with more, neighbours differ as far as four colours allow. Labels that
// enclose others are translucent. A volume that is read in planes is not changed. Adds the colours to `look_why`.
void colour_labels(SceneSetup& setup);

}  // namespace gicube::scene

// The right way round: a volume's axes, brought to the nearest ones of its world.
#pragma once

#include "gicube/scene/volume_file.h"

namespace gicube::scene {

// Permutes and flips the axes of a volume, whose placement is that of its axes as they are stored. Does nothing if the
// file says nothing of them. Volumes with planes are read whole if their z axis changes. Warns if the axes are more
// than a degree off those of the world. Throws FileError: the directions do not span space.
Volume oriented(Volume volume);

}  // namespace gicube::scene

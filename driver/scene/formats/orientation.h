// Orientation of a volume along the nearest axes of its world.
#pragma once

#include "gicube/scene/volume_file.h"

namespace gicube::scene {

// Permutes and flips the axes of a volume, whose placement is that of the stored axes. Does nothing if the file gives
// no directions. A volume with planes is read into memory if its z axis changes. Warns if the axes deviate by more than
// a degree from those of the world. Throws FileError if the directions do not span space.
Volume oriented(Volume volume);

}  // namespace gicube::scene

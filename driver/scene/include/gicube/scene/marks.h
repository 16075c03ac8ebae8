// Marks at the ends of a volume's axes, as radiology labels them, and drawing them into a picture.
#pragma once

#include <array>
#include <string>

#include "gicube/image.h"
#include "gicube/scene/volume_file.h"
#include "gicube/view.h"

namespace gicube::scene {

// The marks at the low and the high end of x, y and z: R L A P I S of a patient, otherwise -x x -y y -z z.
GICUBE_API std::array<std::string, 6> axis_marks(const WorldPlacement& placement);

// Draws opaque lines in the directions of the axes, with the marks at their ends, into the lower left corner of a
// picture of that view: at both ends for a patient, otherwise at the high ones. Those that point away from the viewer
// are darker. Pictures narrower or lower than 64 pixels stay as they are.
GICUBE_API void draw_marks(const WorldPlacement& placement, const Vec3& spacing, const View& view, Image& image);

}  // namespace gicube::scene

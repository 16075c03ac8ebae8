// A scanned volume on a turntable, under a lamp.
#pragma once

#include <gicube/board.h>
#include <gicube/scene/scene.h>

#include <filesystem>

namespace example {

constexpr int kSize = 96;  // voxels along the scene's longest edge

// The scan (NRRD, MetaImage, NIfTI or a folder of slices), half as long as the table is wide, turns by 45 degrees a
// second.
gicube::scene::Scene turntable(const std::filesystem::path& scan);

// The scene at that time. A board has one codebook of normals as long as it has a volume: the board's own, then, if
// others follow.
gicube::Image picture(gicube::Board& board, const gicube::scene::Scene& scene, double seconds);

}  // namespace example

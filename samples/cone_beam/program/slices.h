// Planes of a volume as grey pictures.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "cone_beam/program/options.h"
#include "gicube/image.h"

namespace gicube::samples {

// The plane of voxels `index` along `axis`, black at grey[0] and white at grey[1]. Across runs x (y where the axis is x) to the right,
// up runs z (y where the axis is z).
Image slice_of(const Grid& grid, std::span<const float> values, int axis, int index, const std::array<double, 2>& grey);

// From the thousandth part of the values that is the least to the one that is the greatest [C].
std::array<double, 2> grey_range(std::span<const float> values);

// Writes NAME_x.png and so on, or NAME_z75.png for planes that were asked for. Returns the files. Throws InputError (an index beyond
// the volume), FileError.
std::vector<std::filesystem::path> write_slices(const SliceOptions& options, const Grid& grid,
                                                std::span<const float> values);

}  // namespace gicube::samples

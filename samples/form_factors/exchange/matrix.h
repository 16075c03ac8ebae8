// The exchange areas as a file for other programs.
#pragma once

#include <filesystem>

#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

// FILE: Matrix Market, coordinate real symmetric: X between clusters, one entry a link, in smallest voxel edges squared; a form
// factor is X_ij / w_i. FILE.clusters.csv beside it says of each row, counted from 1: facing, tag, box in voxels, area or
// volume, weight, first and last leaf, and the row of the cluster that it is a part of. Throws FileError.
void write_factors(const RadiosityResult& result, const std::filesystem::path& file);

// Of the clusters' rows.
std::filesystem::path clusters_file(const std::filesystem::path& file);

}  // namespace gicube::samples

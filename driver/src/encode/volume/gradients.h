// Gradients of a volume as codebook codes, by a 3x3x3 Sobel filter or from the caller's own vectors.
#pragma once

#include <cstdint>
#include <vector>

#include "encode/volume/gradient_codebook.h"
#include "gicube/volume.h"

namespace gicube {

// The physical direction in which each voxel's value grows, as the codebook's nearest code; one a voxel, x fastest.
//
// Without view.gradients: central differences smoothed 1-2-1 along both other axes, samples beyond the volume's faces
// being those on them, divided by the voxel edges. Below 1/8 density unit a (smallest) voxel edge there is no gradient:
// code 0. With view.gradients: the supplied direction's code, 0 for the zero vector. With neither: no codes at all.
//
// For a view that passed check_volume(). `threads`: how many may work at once, 0 = as many as the machine has.
std::vector<std::uint16_t> gradient_codes(const VolumeView& view, ValueRange range, const GradientCodebook& codebook,
                                          unsigned threads);

}  // namespace gicube

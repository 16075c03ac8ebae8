// A gradient codebook made for one volume: vector quantisation of its own normals, as [P §2.1] suggests. Reflections show
// an error of a normal twice, and the board's own codebook has up to 3.35 degrees of it.
#pragma once

#include <span>
#include <vector>

#include "gicube/vector.h"

namespace gicube::samples {

constexpr std::size_t kCodes = 2048;  // with the zero vector

// `gradients`: three floats each, as VolumeView::gradients. The result is for Board::set_gradient_codebook(): code 0 is
// the zero vector, the others are unit vectors; as many as there are different directions, at most 2047. Chosen so that
// the farthest direction is near (farthest-point choice), then moved to the means of what they stand for (Lloyd).
std::vector<Vec3> codebook_of(std::span<const float> gradients);

}  // namespace gicube::samples

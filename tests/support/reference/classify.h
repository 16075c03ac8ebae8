// Classification: a sample's colour and opacity by the transfer function of its material.
#pragma once

#include <array>

#include "field.h"
#include "scene.h"

namespace gicube::reference {

// A transfer function's values for one sample: colour not premultiplied, opacity of one (smallest) voxel length.
struct Material {
  std::array<double, 3> colour{};
  double opacity = 0;
};

// Piecewise linear between the points, constant beyond them; at a step the second point's side. Without points: nothing
// is visible. `range` is used by the quantisers alone: the LUT's index is the sample's density rounded to 12 bits.
Material classify(const TransferFunction& function, const Sample& sample, ValueRange range,
                  const Quantisers& quantisers);

}  // namespace gicube::reference

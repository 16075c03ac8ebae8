// Transfer functions: how a material's values become colour and opacity.
#pragma once

#include <array>
#include <vector>

#include "gicube/export.h"

namespace gicube {

using Colour = std::array<double, 3>;  // red green blue, 0..1, display-referred (sRGB)

struct ColourPoint {  // a colour at a value
  double value;       // in the volume's own values
  Colour colour;
};

struct OpacityPoint {  // an opacity at a value
  double value;
  double opacity;  // 0..1, of one voxel length (the smallest voxel edge of an anisotropic volume)
};

// Piecewise linear between its points, constant beyond the first and the last. Values must rise strictly, except that
// two points may share one value: a step, which takes the second's side.
struct GICUBE_API TransferFunction {
  std::vector<ColourPoint> colours{};     // at least one, unless all opacities are 0
  std::vector<OpacityPoint> opacities{};  // at least one

  Colour colour_at(double value) const;
  double opacity_at(double value) const;
};

}  // namespace gicube

#include "light_reference/tiles.h"

#include <algorithm>
#include <cmath>

namespace gicube::light_reference {

double relative_error(const reference::paths::RadiancePicture& picture, int edge) {
  double squares = 0, variances = 0;
  for (int top = 0; top < picture.height; top += edge) {
    for (int left = 0; left < picture.width; left += edge) {
      const int bottom = std::min(top + edge, picture.height), right = std::min(left + edge, picture.width);
      const double pixels = (bottom - top) * (right - left);
      for (std::size_t c = 0; c < 3; ++c) {
        double mean = 0, variance = 0;
        for (int y = top; y < bottom; ++y) {
          for (int x = left; x < right; ++x) {
            const reference::Estimate& one = picture.at(x, y)[c];
            mean += one.mean / pixels;
            variance += std::pow(one.error / pixels, 2);
          }
        }
        squares += pixels * mean * mean;
        variances += pixels * variance;
      }
    }
  }
  return std::sqrt(variances / squares);
}

}  // namespace gicube::light_reference

#include "filter.h"

#include <algorithm>
#include <cmath>

namespace gicube::reference {

namespace {

// The weight of a ray `distance` pixels from a pixel's middle along one axis.
double weight(PixelFilter filter, double distance) {
  if (filter == PixelFilter::kBox) return distance < 0.5 ? 1 : 0;
  return std::max(0.0, 1 - distance);
}

Rgba gather(const Picture& rays, int per_axis, PixelFilter filter, int x, int y) {
  Rgba sum;
  double weights = 0;
  for (int row = std::max(0, (y - 1) * per_axis); row < std::min(rays.height, (y + 2) * per_axis); ++row) {
    for (int column = std::max(0, (x - 1) * per_axis); column < std::min(rays.width, (x + 2) * per_axis); ++column) {
      const double dx = (column + 0.5) / per_axis - (x + 0.5), dy = (row + 0.5) / per_axis - (y + 0.5);
      const double w = weight(filter, std::abs(dx)) * weight(filter, std::abs(dy));
      const Rgba& ray = rays.at(column, row);
      for (std::size_t c = 0; c < 3; ++c) sum.colour[c] += w * ray.colour[c];
      sum.opacity += w * ray.opacity;
      weights += w;
    }
  }
  for (double& c : sum.colour) c /= weights;
  sum.opacity /= weights;
  return sum;
}

}  // namespace

Picture filter(const Picture& rays, int per_axis, PixelFilter filter) {
  Picture picture{rays.width / per_axis, rays.height / per_axis, {}};
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) picture.pixels.push_back(gather(rays, per_axis, filter, x, y));
  }
  return picture;
}

}  // namespace gicube::reference

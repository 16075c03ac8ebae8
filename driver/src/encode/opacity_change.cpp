#include "encode/opacity_change.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "gicube/wire/voxel.h"

namespace gicube {

double largest_opacity_change(std::span<const TransferFunction> functions, ValueRange range, int low, int high,
                              int distance) {
  constexpr std::size_t kDensities = wire::kDensityMax + 1;
  if (functions.empty()) return 0;
  std::vector<double> min_opacity(kDensities, 2), max_opacity(kDensities, -1);
  for (int d = low; d <= high; ++d) {
    const double value = range.low + d * (range.high - range.low) / wire::kDensityMax;
    const auto at = static_cast<std::size_t>(d);
    for (const TransferFunction& function : functions) {
      const double opacity = function.opacity_at(value);
      min_opacity[at] = std::min(min_opacity[at], opacity);
      max_opacity[at] = std::max(max_opacity[at], opacity);
    }
  }
  double widest = 0;
  for (int d = low; d <= high; ++d) {
    for (int e = std::max(low, d - distance); e <= std::min(high, d + distance); ++e) {
      widest = std::max(widest, max_opacity[static_cast<std::size_t>(e)] - min_opacity[static_cast<std::size_t>(d)]);
    }
  }
  return widest;
}

}  // namespace gicube

#include "volume_parts.h"

#include <algorithm>
#include <cmath>

namespace gicube {

VolumeParts::VolumeParts(const Dims& blocks, std::span<const double> costs, int ranks)
    : boxes_(static_cast<std::size_t>(ranks)) {
  Box whole;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    blocks_[axis] = static_cast<std::size_t>(blocks[axis]);
    whole.high[axis] = blocks[axis];
  }
  divide(whole, costs, 0, ranks);
}

// The box for ranks `first` to before first + ranks: by the plane across its longest edge that is nearest to equal
// costs for each.
void VolumeParts::divide(const Box& box, std::span<const double> costs, int first, int ranks) {
  if (ranks == 1) {
    boxes_[static_cast<std::size_t>(first)] = box;
    return;
  }
  std::size_t axis = 0;
  for (std::size_t other = 1; other < 3; ++other) {
    if (box.high[other] - box.low[other] > box.high[axis] - box.low[axis]) axis = other;
  }
  const int length = box.high[axis] - box.low[axis];
  std::vector<double> layers(static_cast<std::size_t>(length));
  double sum = 0;
  for (int z = box.low[2]; z < box.high[2]; ++z) {
    for (int y = box.low[1]; y < box.high[1]; ++y) {
      for (int x = box.low[0]; x < box.high[0]; ++x) {
        const double cost = costs[number(x, y, z)];
        layers[static_cast<std::size_t>(std::array{x, y, z}[axis] - box.low[axis])] += cost;
        sum += cost;
      }
    }
  }
  const int of_below = ranks / 2;
  const double share = static_cast<double>(of_below) / ranks;
  // At least a layer for each side, if there are two.
  int layer = std::clamp(static_cast<int>(std::lround(length * share)), std::min(1, length), std::max(1, length - 1));
  double best = sum, below = 0;
  for (int i = 1; i < length; ++i) {
    below += layers[static_cast<std::size_t>(i) - 1];
    const double miss = std::abs(below - share * sum);
    if (miss < best) best = miss, layer = i;
  }
  Box low = box, high = box;
  low.high[axis] = high.low[axis] = box.low[axis] + layer;
  divide(low, costs, first, of_below);
  divide(high, costs, first + of_below, ranks - of_below);
}

}  // namespace gicube

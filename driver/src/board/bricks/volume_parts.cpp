#include "volume_parts.h"

#include <algorithm>
#include <cmath>

namespace gicube {

VolumeParts::VolumeParts(const Dims& blocks, std::span<const double> costs, int ranks)
    : blocks_(blocks), boxes_(static_cast<std::size_t>(ranks)) {
  divide({{}, blocks}, costs, 0, ranks);
}

// Divides a box among the ranks first .. first + ranks - 1, by the plane across its longest edge that comes nearest to
// equal costs.
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
  for_each_position(box.low, box.high, [&](const Dims& at) {
    const double cost = costs[index_of(blocks_, at)];
    layers[static_cast<std::size_t>(at[axis] - box.low[axis])] += cost;
    sum += cost;
  });
  const int of_below = ranks / 2;
  const double share = static_cast<double>(of_below) / ranks;
  // Each side gets at least one layer if there are two.
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

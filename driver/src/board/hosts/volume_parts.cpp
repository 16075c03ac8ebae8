#include "volume_parts.h"

#include <algorithm>
#include <cmath>

#include "gicube/wire/ray.h"

namespace gicube {

VolumeParts::VolumeParts(const Dims& blocks, std::span<const double> costs, int ranks, std::size_t upright)
    : upright_(upright), boxes_(static_cast<std::size_t>(ranks)) {
  BlockBox whole;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    blocks_[axis] = static_cast<std::size_t>(blocks[axis]);
    whole.high[axis] = blocks[axis];
  }
  divide(whole, costs, 0, ranks);
}

// The box for ranks `first` to before first + ranks: by the plane across its longest edge that is nearest to equal costs for each.
int VolumeParts::divide(const BlockBox& box, std::span<const double> costs, int first, int ranks) {
  const int node = static_cast<int>(nodes_.size());
  nodes_.push_back({.rank = first});
  if (ranks == 1) {
    boxes_[static_cast<std::size_t>(first)] = box;
    return node;
  }
  constexpr int kPreferred = 2;  // chosen: an axis that stands upright counts as twice as long
  std::size_t axis = upright_ == kNone ? 0 : upright_;
  for (std::size_t other = 0; other < 3; ++other) {
    const auto weighted = [&](std::size_t a) { return (box.high[a] - box.low[a]) * (a == upright_ ? kPreferred : 1); };
    if (weighted(other) > weighted(axis)) axis = other;
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
  BlockBox low = box, high = box;
  low.high[axis] = high.low[axis] = box.low[axis] + layer;
  const int lower = divide(low, costs, first, of_below);
  const int upper = divide(high, costs, first + of_below, ranks - of_below);
  nodes_[static_cast<std::size_t>(node)] = {axis, box.low[axis] + layer, -1, lower, upper};
  return node;
}

std::pair<int, int> VolumeParts::rows(int rank, const wire::RenderCommand& camera, int n) const {
  // Voxels by which rays may leave their lines: what Board::render() allows, and roundings.
  constexpr double kDrift = 1.5;
  const std::pair all{0, int{camera.height}};
  const BlockBox& of = box(rank);
  double first = camera.height, last = -1;
  const auto dot = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const auto cross = [](const auto& a, const auto& b) {
    return std::array{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto of_forward = cross(camera.du, camera.dv), of_dv = cross(camera.forward, camera.du);
  const double volume = dot(of_forward, camera.forward);
  for (unsigned corner = 0; corner < 8; ++corner) {
    std::array<double, 3> to{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool high = (corner >> axis & 1u) != 0;
      to[axis] = (high ? of.high[axis] * n + kDrift : of.low[axis] * n - kDrift) - camera.origin[axis];
    }
    // to = t forward + x du + y dv of parallel rays; of others t (forward + x du + y dv).
    const double t = dot(of_forward, to) / volume;
    double row = dot(of_dv, to) / volume;
    if (camera.projection == wire::Projection::kPerspective) {
      if (!(t > 0)) return all;
      row /= t;
    }
    if (!std::isfinite(row)) return all;
    first = std::min(first, row);
    last = std::max(last, row);
  }
  const auto at = [&](double row) {
    return static_cast<int>(std::clamp(row, 0.0, static_cast<double>(camera.height)));
  };
  return {at(std::floor(first) - 1), at(std::ceil(last) + 1)};
}

std::vector<int> VolumeParts::front_to_back(const View& view, int n) const {
  // As the board rounds the eye, from which rays set out if it is inside of the volume.
  const auto rounded = [](double voxels) { return std::round(voxels * wire::kVoxel) / wire::kVoxel; };
  const std::array eye{view.eye.x, view.eye.y, view.eye.z};
  const std::array at{view.look_at.x, view.look_at.y, view.look_at.z};
  std::vector<int> order, left{0};
  while (!left.empty()) {
    const Node& node = nodes_[static_cast<std::size_t>(left.back())];
    left.pop_back();
    if (node.rank >= 0) {
      order.push_back(node.rank);
      continue;
    }
    const bool parallel = view.orthographic_height > 0;
    const bool below_first = parallel ? at[node.axis] >= eye[node.axis] : rounded(eye[node.axis]) < node.plane * n;
    left.push_back(below_first ? node.above : node.below);
    left.push_back(below_first ? node.below : node.above);
  }
  return order;
}

}  // namespace gicube

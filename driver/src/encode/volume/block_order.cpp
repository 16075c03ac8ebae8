#include "encode/volume/block_order.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "encode/vectors.h"

namespace gicube {

BlockOrder::BlockOrder(Dims blocks, int n, const wire::RenderCommand& camera, std::span<const CutPlane> cut_planes)
    : blocks_(blocks), n_(n) {
  const bool parallel = camera.projection == wire::Projection::kOrthographic;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int count = blocks[axis];
    // Parallel rays come from one end, or keep their index. Perspective rays come from the eye's block.
    int from = static_cast<int>(std::clamp(std::floor(camera.origin[axis] / n), -1.0, static_cast<double>(count)));
    const double forward = camera.forward[axis];
    if (parallel) from = forward < 0 ? count : -1;
    const bool moves = !parallel || forward != 0;
    for (int i = 0; i < count; ++i) {
      axes_[axis].distance.push_back(moves ? std::abs(i - from) : 0);
      axes_[axis].before.push_back(!moves || i == from ? 0 : i > from ? -1 : 1);
    }
  }
  add_pyramid(camera);
  for (const CutPlane& plane : cut_planes) seen_.push_back({plane.normal, plane.offset});
  order_.resize(voxel_count(blocks));
  std::iota(order_.begin(), order_.end(), std::uint32_t{0});
  std::vector<int> distance;
  for (const std::uint32_t block : order_) {
    const auto at = position_of(block, blocks_);
    int sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) sum += axes_[axis].distance[static_cast<std::size_t>(at[axis])];
    distance.push_back(sum);
  }
  std::ranges::stable_sort(order_, {}, [&](std::uint32_t block) { return distance[block]; });
}

// Adds the four planes that enclose all rays of the picture, or of its part.
void BlockOrder::add_pyramid(const wire::RenderCommand& camera) {
  const Vec3 origin = to_vec3(camera.origin), forward = to_vec3(camera.forward);
  double top = 0, bottom = camera.height;  // rows
  if (camera.parts != 0 &&
      camera.strip_rows * camera.parts >= camera.height) {  // one strip; the tent filter adds half a row
    top = std::max(camera.part * camera.strip_rows - 1, 0);
    bottom = std::min((camera.part + 1) * camera.strip_rows + 1, int{camera.height});
  }
  const Vec3 across = camera.width * to_vec3(camera.du);
  const Vec3 up = top * to_vec3(camera.dv), down = bottom * to_vec3(camera.dv);
  const std::array<Vec3, 5> corners{up, across + up, across + down, down, 0.5 * (across + up + down)};
  const bool parallel = camera.projection == wire::Projection::kOrthographic;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 a = corners[i], b = corners[(i + 1) % 4], middle = corners[4];
    Vec3 normal = parallel ? cross(forward, b - a) : cross(forward + a, forward + b);
    const Vec3 point = parallel ? origin + a : origin;
    if (dot(normal, parallel ? middle - a : forward + middle) < 0) normal = -1.0 * normal;
    seen_.push_back({normal, dot(normal, point)});
  }
}

bool BlockOrder::is_seen(const Dims& block) const {
  constexpr double kDrift = 1;  // voxels: steps with which rays drift further are refused
  return std::ranges::all_of(seen_, [&](const HalfSpace& half) {
    const auto furthest = [&](std::size_t axis, double slope) {
      const double low = block[axis] * static_cast<double>(n_) - kDrift;
      return slope * (slope > 0 ? low + n_ + 2 * kDrift : low);
    };
    return furthest(0, half.normal.x) + furthest(1, half.normal.y) + furthest(2, half.normal.z) >= half.offset;
  });
}

std::vector<std::size_t> BlockOrder::reached_from(std::span<const wire::WaitingBlock> waiting) const {
  std::vector<std::uint8_t> reached(order_.size());
  for (const wire::WaitingBlock& each : waiting) reached[each.block] = 1;
  std::vector<std::size_t> out;
  const auto nx = static_cast<std::ptrdiff_t>(blocks_[0]), ny = static_cast<std::ptrdiff_t>(blocks_[1]);
  for (const std::size_t block : order_) {
    const auto at = position_of(block, blocks_);
    const auto before = [&](std::size_t axis) { return axes_[axis].before[static_cast<std::size_t>(at[axis])]; };
    for (unsigned axes = 1; axes < 8 && reached[block] == 0; ++axes) {
      std::ptrdiff_t from = static_cast<std::ptrdiff_t>(block), stride = 1;
      bool inside = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if ((axes >> axis & 1) != 0) {
          const int step = before(axis);
          inside = inside && step != 0 && at[axis] + step >= 0 && at[axis] + step < blocks_[axis];
          from += step * stride;
        }
        stride *= axis == 0 ? nx : ny;
      }
      if (inside && reached[static_cast<std::size_t>(from)] != 0 && is_seen(at)) reached[block] = 1;
    }
    if (reached[block] != 0) out.push_back(block);
  }
  return out;
}

}  // namespace gicube

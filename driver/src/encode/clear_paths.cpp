#include "encode/clear_paths.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "encode/pairs.h"
#include "gicube/wire/ray.h"

namespace gicube {
namespace {

struct Bounds {
  wire::Vector low{}, high{};
};

Bounds bounds_of(const wire::Element& element) {
  Bounds bounds{wire::point_of(element, {}), wire::point_of(element, {})};
  for (int corner = 1; corner < 8; ++corner) {
    const wire::Vector at =
        wire::point_of(element, {corner & 1 ? 1.0 : 0.0, corner & 2 ? 1.0 : 0.0, corner & 4 ? 1.0 : 0.0});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.low[axis] = std::min(bounds.low[axis], at[axis]);
      bounds.high[axis] = std::max(bounds.high[axis], at[axis]);
    }
  }
  return bounds;
}

// How far on one axis, in voxels, a sample may lie from the straight way between the two points: the position, each part
// of the direction and each step are rounded to 1/16384 voxel, a step's length to 1/65536, and half of the first step is
// rounded on its own. Generously.
double stray(const Bounds& a, const Bounds& b, double step) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double way = std::max(b.high[axis] - a.low[axis], a.high[axis] - b.low[axis]);
    square += way * way;
  }
  const double length = std::sqrt(square);
  return (4 + length + 2 * std::ceil(length / step)) / wire::kVoxel;
}

// A share of the way from a to b, 0..1; empty if begin > end.
struct Part {
  double begin = 0, end = 1;
};

// Of the part, that where a number which goes from `at_a` to `at_b` is at most `limit`.
Part where_below(Part part, double at_a, double at_b, double limit) {
  const double slope = at_b - at_a;
  if (slope == 0) return at_a <= limit ? part : Part{1, 0};
  const double crossing = (limit - at_a) / slope;
  return slope > 0 ? Part{part.begin, std::min(part.end, crossing)} : Part{std::max(part.begin, crossing), part.end};
}

// The blocks of one axis that an interval of voxels touches.
struct Range {
  int begin = 0, end = 0;  // the last one
};

Range blocks_between(double low, double high, int block_voxels, int blocks) {
  return {std::clamp(static_cast<int>(std::floor(low / block_voxels)), 0, blocks - 1),
          std::clamp(static_cast<int>(std::floor(high / block_voxels)), 0, blocks - 1)};
}

bool all_empty(const std::array<Range, 3>& range, const BlockFlags& flags) {
  const auto [nx, ny, nz] = flags.blocks;
  for (int z = range[2].begin; z <= range[2].end; ++z) {
    for (int y = range[1].begin; y <= range[1].end; ++y) {
      for (int x = range[0].begin; x <= range[0].end; ++x) {
        if (flags.empty[static_cast<std::size_t>(x) +
                        static_cast<std::size_t>(nx) * static_cast<std::size_t>(y + ny * z)] == 0) {
          return false;
        }
      }
    }
  }
  return true;
}

// The axis along which the elements are furthest apart: layers of blocks across it hold the least of the hull each.
std::size_t main_axis(const Bounds& a, const Bounds& b) {
  std::size_t best = 0;
  double furthest = -1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double apart = std::abs(b.low[axis] + b.high[axis] - a.low[axis] - a.high[axis]);
    if (apart > furthest) best = axis, furthest = apart;
  }
  return best;
}

}  // namespace

// At the share t of the way all rays are within the bounds (1 - t) a + t b, whose faces go straight from a's to b's.
bool is_clear(const wire::Element& from, const wire::Element& to, const BlockFlags& flags, double step) {
  Bounds a = bounds_of(from), b = bounds_of(to);
  const double margin = stray(a, b, step);
  for (Bounds* bounds : {&a, &b}) {
    for (std::size_t axis = 0; axis < 3; ++axis) bounds->low[axis] -= margin, bounds->high[axis] += margin;
  }
  const int n = flags.block_voxels;
  const std::size_t main = main_axis(a, b);
  std::array<Range, 3> range{};
  const Range layers =
      blocks_between(std::min(a.low[main], b.low[main]), std::max(a.high[main], b.high[main]), n, flags.blocks[main]);
  for (int layer = layers.begin; layer <= layers.end; ++layer) {
    Part part;
    part = where_below(part, a.low[main], b.low[main], n * (layer + 1.0));
    part = where_below(part, -a.high[main], -b.high[main], -n * static_cast<double>(layer));
    part.begin = std::max(0.0, part.begin), part.end = std::min(1.0, part.end);
    if (part.begin > part.end) continue;
    range[main] = {layer, layer};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == main) continue;
      const double low =
          std::min(std::lerp(a.low[axis], b.low[axis], part.begin), std::lerp(a.low[axis], b.low[axis], part.end));
      const double high =
          std::max(std::lerp(a.high[axis], b.high[axis], part.begin), std::lerp(a.high[axis], b.high[axis], part.end));
      range[axis] = blocks_between(low, high, n, flags.blocks[axis]);
    }
    if (!all_empty(range, flags)) return false;
  }
  return true;
}

PairFactor clear_factor(const wire::Element& a, const wire::Element& b, std::uint32_t id, const PairRequest& request,
                        Vec3 spacing) {
  const wire::Vector edges{spacing.x, spacing.y, spacing.z};
  const std::array normals{wire::normal_of(a, edges), wire::normal_of(b, edges)};
  wire::PairSum sum(request.rays);
  for (std::uint32_t i = 0; i < request.rays; ++i) {
    sum.add(i, wire::pair_sample(a, b, normals, edges, id, request.seed, request.first + i).weight, 1);
  }
  PairFactor factor = from_wire(sum.result());
  factor.clear = true;
  return factor;
}

}  // namespace gicube

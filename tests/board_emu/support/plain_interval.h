// The integration interval of a lighting ray's sample by plain scalar code, which shares nothing with
// datapath/interval-inl.h: the oracle of that source, which serves both a ray alone and rays in lanes.
#pragma once

#include <algorithm>
#include <array>
#include <limits>

#include "datapath/ray_step.h"

namespace gicube::emu {

// The interval in which the ray is in a cell, in steps from its sample.
struct PlainReach {
  double entry = -std::numeric_limits<double>::infinity(), exit = std::numeric_limits<double>::infinity();
};

class PlainPath {
 public:
  explicit PlainPath(const RayState& ray) : ray_(ray) {
    for (std::size_t axis = 0; axis < 3; ++axis) inverse_[axis] = 1.0 / ray.slope(axis);
    own_ = reach(ray.position, 0);
  }

  const PlainReach& own() const { return own_; }
  // An interval begins and ends half way between the cells of neighbouring samples, so that the intervals cover the ray
  // once.
  double begin() const {
    const Point previous = moved(-1);
    if (same_cell(previous)) return -0.5;
    return (std::min(reach(previous, -1).exit, own_.entry) + own_.entry) / 2;
  }
  double end(const Point& extent) const {
    const Point next = moved(1);
    if (!inside(next, extent)) return to_the_face(extent);  // the path segment's last sample
    if (same_cell(next)) return 0.5;
    return (own_.exit + std::max(own_.exit, reach(next, 1).entry)) / 2;
  }

 private:
  Point moved(int steps) const { return units_of(emu::moved(ray_.fine_position(), ray_.fine_step(), steps)); }
  bool same_cell(const Point& other) const {
    const Point& at = ray_.position;
    return (((at[0] ^ other[0]) | (at[1] ^ other[1]) | (at[2] ^ other[2])) & -wire::kVoxel) == 0;
  }
  // The interval in the cell of a position that is `steps` away.
  PlainReach reach(const Point& position, double steps) const {
    PlainReach out;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (ray_.slope(axis) == 0) continue;
      const std::int32_t at = position[axis] & (wire::kVoxel - 1);
      const double low = -at * inverse_[axis] + steps, high = (wire::kVoxel - at) * inverse_[axis] + steps;
      out.entry = std::max(out.entry, std::min(low, high));
      out.exit = std::min(out.exit, std::max(low, high));
    }
    return out;
  }
  double to_the_face(const Point& extent) const {
    double steps = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (ray_.slope(axis) == 0) continue;
      const std::int32_t at = ray_.position[axis];
      steps = std::min(steps, (ray_.slope(axis) > 0 ? extent[axis] - at : -at) * inverse_[axis]);
    }
    return steps;
  }

  const RayState& ray_;
  std::array<double, 3> inverse_;
  PlainReach own_;
};

}  // namespace gicube::emu

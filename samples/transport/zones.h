// The zones of a medium: cubes of some voxels, by which light in it is kept.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "transport/medium.h"

namespace gicube::samples {

class Zones {
 public:
  // `edge`: voxels. The last zones along an axis may be smaller.
  Zones(const Medium& medium, int edge) : medium_(medium), edge_(edge) {
    for (std::size_t axis = 0; axis < 3; ++axis) count_[axis] = (medium.dims()[axis] - 2) / edge + 1;
  }

  std::size_t count() const { return index(count_[0] - 1, count_[1] - 1, count_[2] - 1) + 1; }
  std::size_t at(Vec3 place) const {
    const Vec3 voxel = medium_.voxel_of(place);
    const auto part = [&](double v, std::size_t axis) {
      return std::clamp(static_cast<int>(std::floor(v / edge_)), 0, count_[axis] - 1);
    };
    return index(part(voxel.x, 0), part(voxel.y, 1), part(voxel.z, 2));
  }

  // An even place in a zone.
  Vec3 place(std::size_t zone, PathRandom& random) const {
    const auto low = lowest(zone);
    std::array<double, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      at[axis] = low[axis] + random.uniform() * std::min<double>(edge_, medium_.dims()[axis] - 1 - low[axis]);
    return medium_.place_of({at[0], at[1], at[2]});
  }

  // The middles of the eighths of a zone's voxels: visit(place).
  template <class Visit>
  void sample(std::size_t zone, const Visit& visit) const {
    const auto low = lowest(zone);
    const int n = 2 * edge_;
    for (int i = 0; i < n * n * n; ++i) {
      const Vec3 voxel{low[0] + (i % n + 0.5) / 2, low[1] + (i / n % n + 0.5) / 2, low[2] + (i / n / n + 0.5) / 2};
      const Dims& dims = medium_.dims();
      if (voxel.x <= dims[0] - 1 && voxel.y <= dims[1] - 1 && voxel.z <= dims[2] - 1) visit(medium_.place_of(voxel));
    }
  }

  // The zones whose middles are the corners round a place, with their trilinear weights: visit(zone, weight).
  template <class Visit>
  void around(Vec3 place, const Visit& visit) const {
    const Vec3 voxel = medium_.voxel_of(place);
    const std::array<double, 3> at{voxel.x / edge_ - 0.5, voxel.y / edge_ - 0.5, voxel.z / edge_ - 0.5};
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::array<int, 3> zone{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int high = corner >> axis & 1, low = static_cast<int>(std::floor(at[axis]));
        zone[axis] = low + high;
        const bool is_one = zone[axis] >= 0 && zone[axis] < count_[axis];
        weight *= !is_one ? 0 : high != 0 ? at[axis] - low : 1 - (at[axis] - low);
      }
      if (weight > 0) visit(index(zone[0], zone[1], zone[2]), weight);
    }
  }

 private:
  std::size_t index(int x, int y, int z) const { return static_cast<std::size_t>((z * count_[1] + y) * count_[0] + x); }
  std::array<double, 3> lowest(std::size_t zone) const {
    const int i = static_cast<int>(zone), x = i % count_[0], y = i / count_[0] % count_[1],
              z = i / count_[0] / count_[1];
    return {1.0 * x * edge_, 1.0 * y * edge_, 1.0 * z * edge_};
  }

  const Medium& medium_;
  int edge_;
  std::array<int, 3> count_{};
};

}  // namespace gicube::samples

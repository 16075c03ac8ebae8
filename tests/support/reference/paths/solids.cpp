#include "solids.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gicube::reference::paths {

namespace {

constexpr std::array<std::size_t, 3> kAxes{0, 1, 2};

std::array<double, 3> parts(Vec3 v) { return {v.x, v.y, v.z}; }

constexpr double kHair = 1e-9;  // interpolation rounds

struct Turns {
  std::array<double, 3> at{};
  std::size_t count = 0;
  const double* begin() const { return at.data(); }
  const double* end() const { return at.data() + count; }
};

// Where in 0..1 a cubic, given by its values at 0, 1/3, 2/3 and 1, turns: roots of its derivative.
Turns turns(const std::array<double, 4>& f) {
  const double c1 = (-11 * f[0] + 18 * f[1] - 9 * f[2] + 2 * f[3]) / 2;
  const double c2 = 9 * (2 * f[0] - 5 * f[1] + 4 * f[2] - f[3]) / 2;
  const double c3 = 9 * (-f[0] + 3 * f[1] - 3 * f[2] + f[3]) / 2;
  const double a = 3 * c3, b = 2 * c2, root = b * b - 4 * a * c1;
  Turns out;
  if (root >= 0) {
    const double q = -(b + std::copysign(std::sqrt(root), b)) / 2;
    for (const double t : {q / a, c1 / q}) {
      if (t > 0 && t < 1) out.at[out.count++] = t;
    }
    if (out.count == 2 && out.at[0] > out.at[1]) std::swap(out.at[0], out.at[1]);
  }
  out.at[out.count++] = 1;
  return out;
}

}  // namespace

Solids::Solids(const PathScene& scene, const Field& field)
    : field_(field), levels_(scene.surfaces), reach_(scene.normal_reach) {
  any_ = std::any_of(levels_.begin(), levels_.end(), [](const auto& level) { return level.has_value(); });
  if (!any_) return;
  const Dims dims = field.volume().dims;
  for (const std::size_t axis : kAxes) dims_[axis] = static_cast<std::size_t>(dims[axis]);
  for (int z = 0; z < dims[2]; ++z) {
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x) {
        values_.push_back(field.sample({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}).value);
      }
    }
  }
  empty_ = empty_space();
}

// A cell is empty if none of the tags within it, which are those of its corners, has a surface that its field can
// reach.
EmptySpace Solids::empty_space() const {
  std::array<int, 3> cells{};
  for (const std::size_t axis : kAxes) cells[axis] = static_cast<int>(dims_[axis]) - 1;
  std::vector<std::uint8_t> something;
  for (int z = 0; z < cells[2]; ++z) {
    for (int y = 0; y < cells[1]; ++y) {
      for (int x = 0; x < cells[0]; ++x) {
        const Cell here = cell({x + 0.5, y + 0.5, z + 0.5});
        const double most = *std::max_element(here.corners.begin(), here.corners.end());
        bool any = false;
        for (int i = 0; i < 8; ++i) {
          const Vec3 corner{x + (i & 1) * 1.0, y + (i >> 1 & 1) * 1.0, z + (i >> 2) * 1.0};
          const auto& level = levels_[static_cast<std::size_t>(field_.tag(corner))];
          any = any || (level && most >= *level - kHair * std::abs(*level));
        }
        something.push_back(any ? 1 : 0);
      }
    }
  }
  return {cells, std::move(something)};
}

Solids::Cell Solids::cell(Vec3 middle) const {
  Cell out{{}, field_.tag(middle)};
  const auto at = parts(middle);
  for (const std::size_t axis : kAxes) {
    out.low[axis] = std::clamp(std::floor(at[axis]), 0.0, static_cast<double>(dims_[axis]) - 2);
  }
  const std::size_t row = dims_[0], slice = row * dims_[1];
  const double* first = &values_[static_cast<std::size_t>(out.low[2]) * slice +
                                 static_cast<std::size_t>(out.low[1]) * row + static_cast<std::size_t>(out.low[0])];
  out.corners = {first[0],     first[1],         first[row],         first[row + 1],
                 first[slice], first[slice + 1], first[slice + row], first[slice + row + 1]};
  return out;
}

Vec3 Solids::gradient(const Cell& cell, Vec3 voxel) const {
  if (reach_ > 0) {
    const auto slope = [&](Vec3 step) { return field_.sample(voxel + step).value - field_.sample(voxel - step).value; };
    return {slope({reach_, 0, 0}), slope({0, reach_, 0}), slope({0, 0, reach_})};
  }
  const auto at = parts(voxel);
  std::array<double, 3> sum{};
  for (const std::size_t along : kAxes) {
    for (std::size_t i = 0; i < 8; ++i) {
      double weight = (i >> along & 1) != 0 ? 1 : -1;
      for (const std::size_t axis : kAxes) {
        const double way = at[axis] - cell.low[axis];
        if (axis != along) weight *= (i >> axis & 1) != 0 ? way : 1 - way;
      }
      sum[along] += weight * cell.corners[i];
    }
  }
  return {sum[0], sum[1], sum[2]};
}

// Half a voxel at a time: there the tag is one and the field one cubic.
std::optional<Solids::Crossing> Solids::crossing(Vec3 origin, Vec3 direction, double begin, double end,
                                                 bool inside) const {
  const auto from = parts(origin), step = parts(direction);
  const auto border = [&](double distance) {
    double next = end;
    for (const std::size_t axis : kAxes) {
      if (step[axis] == 0) continue;
      const double at = 2 * (from[axis] + distance * step[axis]);
      double face = step[axis] > 0 ? std::floor(at) + 1 : std::ceil(at) - 1;
      double there = (face / 2 - from[axis]) / step[axis];
      if (there <= distance) there = (face / 2 + std::copysign(0.5, step[axis]) - from[axis]) / step[axis];
      next = std::min(next, there);
    }
    return next;
  };
  for (double a = begin; a < end;) {
    if (!inside) {
      const double leap = empty_.leave(from, step, a);
      if (leap >= end) return std::nullopt;
      if (leap > a) {
        a = leap;
        continue;
      }
    }
    const double b = border(a);
    const auto place = [&](double t) { return origin + (a + (b - a) * t) * direction; };
    const Cell here = cell(place(0.5));
    const auto& level = levels_[static_cast<std::size_t>(here.tag)];
    if (!level) {
      if (inside) return Crossing{a, here.tag, {}};
    } else {
      // Along one ray, from `a` to `b`.
      const auto value = [&here, on = parts(place(0)), to = parts(place(1))](double t) {
        std::array<double, 3> w{};
        for (const std::size_t axis : kAxes) w[axis] = on[axis] + (to[axis] - on[axis]) * t - here.low[axis];
        const auto mix = [](double p, double q, double way) { return p + (q - p) * way; };
        const std::array<double, 8>& c = here.corners;
        return mix(mix(mix(c[0], c[1], w[0]), mix(c[2], c[3], w[0]), w[1]),
                   mix(mix(c[4], c[5], w[0]), mix(c[6], c[7], w[0]), w[1]), w[2]);
      };
      const auto solid = [&](double t) { return value(t) >= *level; };
      std::array<double, 4> f{};
      for (std::size_t i = 0; i < 4; ++i) f[i] = value(static_cast<double>(i) / 3);
      double low = 0;
      if (solid(0) != inside) return Crossing{a, here.tag, -1.0 * gradient(here, place(0))};
      for (const double turn : turns(f)) {
        if (solid(turn) == inside) {
          low = turn;
          continue;
        }
        double high = turn;
        for (int i = 0; i < 60; ++i) (solid((low + high) / 2) == inside ? low : high) = (low + high) / 2;
        return Crossing{a + (b - a) * high, here.tag, -1.0 * gradient(here, place(high))};
      }
    }
    a = b;
  }
  return std::nullopt;
}

}  // namespace gicube::reference::paths

#include "solids.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gicube::reference::paths {

namespace {

constexpr std::array<std::size_t, 3> kAxes{0, 1, 2};

std::array<double, 3> parts(Vec3 v) { return {v.x, v.y, v.z}; }

// Where in 0..1 a cubic, given by its values at 0, 1/3, 2/3 and 1, turns: roots of its derivative.
std::vector<double> turns(const std::array<double, 4>& f) {
  const double c1 = (-11 * f[0] + 18 * f[1] - 9 * f[2] + 2 * f[3]) / 2;
  const double c2 = 9 * (2 * f[0] - 5 * f[1] + 4 * f[2] - f[3]) / 2;
  const double c3 = 9 * (-f[0] + 3 * f[1] - 3 * f[2] + f[3]) / 2;
  const double a = 3 * c3, b = 2 * c2, root = b * b - 4 * a * c1;
  std::vector<double> out;
  if (root >= 0) {
    const double q = -(b + std::copysign(std::sqrt(root), b)) / 2;
    for (const double t : {q / a, c1 / q}) {
      if (t > 0 && t < 1) out.push_back(t);
    }
    std::sort(out.begin(), out.end());
  }
  out.push_back(1);
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
}

Solids::Cell Solids::cell(Vec3 middle) const {
  Cell out{{}, field_.tag(middle)};
  const auto at = parts(middle);
  for (const std::size_t axis : kAxes) {
    out.cube[axis] =
        static_cast<std::size_t>(std::clamp(std::floor(at[axis]), 0.0, static_cast<double>(dims_[axis]) - 2));
  }
  return out;
}

double Solids::corner(const Cell& cell, std::size_t i) const {
  const std::size_t x = cell.cube[0] + (i & 1), y = cell.cube[1] + (i >> 1 & 1), z = cell.cube[2] + (i >> 2);
  return values_[(z * dims_[1] + y) * dims_[0] + x];
}

double Solids::value(const Cell& cell, Vec3 voxel) const {
  const auto at = parts(voxel);
  double sum = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    double weight = 1;
    for (const std::size_t axis : kAxes) {
      const double way = at[axis] - static_cast<double>(cell.cube[axis]);
      weight *= (i >> axis & 1) != 0 ? way : 1 - way;
    }
    sum += weight * corner(cell, i);
  }
  return sum;
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
        const double way = at[axis] - static_cast<double>(cell.cube[axis]);
        if (axis != along) weight *= (i >> axis & 1) != 0 ? way : 1 - way;
      }
      sum[along] += weight * corner(cell, i);
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
    const double b = border(a);
    const auto place = [&](double t) { return origin + (a + (b - a) * t) * direction; };
    const Cell here = cell(place(0.5));
    const auto& level = levels_[static_cast<std::size_t>(here.tag)];
    if (!level) {
      if (inside) return Crossing{a, here.tag, {}};
    } else {
      const auto solid = [&](double t) { return value(here, place(t)) >= *level; };
      std::array<double, 4> f{};
      for (std::size_t i = 0; i < 4; ++i) f[i] = value(here, place(static_cast<double>(i) / 3));
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

#include "form_factors/exchange/box_factor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace gicube::samples {
namespace {

// An interval of the difference of two coordinates, and its linear density there.
struct Interval {
  double low = 0, high = 0;
  double at_low = 1, at_high = 1;
};
using Intervals = std::vector<Interval>;
using Cell = std::array<Interval, 3>;

Interval part(const Interval& of, double low, double high) {
  const auto density = [&](double t) { return std::lerp(of.at_low, of.at_high, (t - of.low) / (of.high - of.low)); };
  return {low, high, density(low), density(high)};
}

// Intervals of b - a for points uniform in both, divided at zero and at the bends of the density.
Intervals differences(double a_low, double a_high, double b_low, double b_high) {
  const double a = a_high - a_low, b = b_high - b_low;
  if (a == 0 && b == 0) return {{b_low - a_low, b_low - a_low}};
  std::array ends{b_low - a_high, b_low - a_low, b_high - a_high, b_high - a_low};
  std::ranges::sort(ends);
  const double top = 1 / std::max(a, b), outer = a == 0 || b == 0 ? top : 0;
  const std::array density{outer, top, top, outer};
  Intervals out;
  for (std::size_t i = 0; i < 3; ++i) {
    const Interval whole{ends[i], ends[i + 1], density[i], density[i + 1]};
    if (!(whole.low < whole.high)) continue;
    if (whole.low < 0 && whole.high > 0) {
      out.push_back(part(whole, whole.low, 0));
      out.push_back(part(whole, 0, whole.high));
    } else {
      out.push_back(whole);
    }
  }
  return out;
}

// Gauss-Legendre points and weights on -1..1.
struct Rule {
  std::size_t points;
  std::array<double, 4> at, weight;
};
constexpr Rule kTwo{2, {-0.5773502691896257, 0.5773502691896257}, {1, 1}};
constexpr Rule kThree{3, {-0.7745966692414834, 0, 0.7745966692414834}, {5.0 / 9, 8.0 / 9, 5.0 / 9}};
constexpr Rule kFour{4,
                     {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526},
                     {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538}};

// Number of points by the distance of the integrand's only singularity, in sizes.
const Rule& rule_at(double sizes) { return sizes < 2 ? kFour : sizes < 8 ? kThree : kTwo; }

class Integral {
 public:
  Integral(std::uint8_t a, std::uint8_t b, WayFactor& out) : a_(a), b_(b), out_(out) {}

  void over(const std::array<Intervals, 3>& axes, int depth) const {
    for (const Interval& x : axes[0]) {
      for (const Interval& y : axes[1]) {
        for (const Interval& z : axes[2]) over(Cell{x, y, z}, depth);
      }
    }
  }

 private:
  void over(const Cell& cell, int depth) const {
    double square = 0, size = 0;
    for (const Interval& t : cell) {
      const double near = t.low > 0 ? t.low : t.high < 0 ? -t.high : 0;
      square += near * near;
      size = std::max(size, t.high - t.low);
    }
    const double distance = std::sqrt(square);
    if (size <= distance || depth == 0) return sum(cell, rule_at(distance / size));
    // Halves the long axes, so that parts become cubes.
    std::array<Intervals, 3> parts;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Interval& t = cell[axis];
      if (2 * (t.high - t.low) <= size) {
        parts[axis] = {t};
      } else {
        const double middle = 0.5 * (t.low + t.high);
        parts[axis] = {part(t, t.low, middle), part(t, middle, t.high)};
      }
    }
    over(parts, depth - 1);
  }

  struct Point {
    double t, weight;
  };
  static std::size_t points(const Interval& t, const Rule& rule, std::array<Point, 4>& out) {
    if (t.low == t.high) {
      out[0] = {t.low, 1};
      return 1;
    }
    const double half = 0.5 * (t.high - t.low);
    for (std::size_t i = 0; i < rule.points; ++i) {
      const double s = 0.5 * (1 + rule.at[i]);
      out[i] = {std::lerp(t.low, t.high, s), half * rule.weight[i] * std::lerp(t.at_low, t.at_high, s)};
    }
    return rule.points;
  }

  void sum(const Cell& cell, const Rule& rule) const {
    std::array<std::array<Point, 4>, 3> at;
    std::array<std::size_t, 3> count;
    for (std::size_t axis = 0; axis < 3; ++axis) count[axis] = points(cell[axis], rule, at[axis]);
    for (std::size_t i = 0; i < count[0]; ++i) {
      for (std::size_t j = 0; j < count[1]; ++j) {
        const double weight = at[0][i].weight * at[1][j].weight;
        for (std::size_t k = 0; k < count[2]; ++k) {
          add(weight * at[2][k].weight, {at[0][i].t, at[1][j].t, at[2][k].t});
        }
      }
    }
  }

  static double along(std::uint8_t facing, const std::array<double, 3>& t) {
    const double s = t[facing / 2u];
    return facing % 2 == 1 ? s : -s;
  }

  void add(double weight, const std::array<double, 3>& t) const {
    const double square = t[0] * t[0] + t[1] * t[1] + t[2] * t[2], r = std::sqrt(square);
    double factor = weight / (std::numbers::pi * square);
    if (a_ != kMedium) factor *= std::max(0.0, along(a_, t)) / r;
    if (b_ != kMedium) factor *= std::max(0.0, -along(b_, t)) / r;
    out_.add(r, factor);
  }

  std::uint8_t a_, b_;
  WayFactor& out_;
};

constexpr int kMaxDepth = 12;  // chosen: about 2^-12 of the light between touching elements has no error bound

}  // namespace

WayFactor::WayFactor(const AxisBox& a, const AxisBox& b) {
  std::array<Intervals, 3> axes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    axes[axis] = differences(a.low[axis], a.high[axis], b.low[axis], b.high[axis]);
  }
  // Two faces in one plane, or of one facing, do not see each other.
  const auto flat = [](const AxisBox& box) { return box.facing != kMedium; };
  if (flat(a) && flat(b) && a.facing / 2 == b.facing / 2) {
    const Interval& apart = axes[a.facing / 2u].front();
    if (a.facing == b.facing || apart.low == 0) return;
  }
  double longest = 0;
  for (const Intervals& axis : axes) longest = std::hypot(longest, std::max(-axis.front().low, axis.back().high));
  bins_per_length_ = kBins / longest;
  Integral(a.facing, b.facing, *this).over(axes, kMaxDepth);
}

double WayFactor::at(double kappa) const {
  double sum = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    if (factor_[bin] > 0) sum += factor_[bin] * (kappa > 0 ? std::exp(-kappa * way_[bin] / factor_[bin]) : 1);
  }
  return sum;
}

double BoxFactors::of(const Cluster& a, const Cluster& b, double kappa) {
  const auto halves = [](double x) { return static_cast<std::int16_t>(std::lround(2 * x)); };
  Key key{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    key[axis] = halves(a.high[axis] - a.low[axis]);
    key[3 + axis] = halves(b.high[axis] - b.low[axis]);
    key[6 + axis] = halves(b.low[axis] - a.low[axis]);
    // Perpendicular to the faces' normals, a mirror image has the same factor.
    const bool normal =
        (a.facing != kMedium && a.facing / 2u == axis) || (b.facing != kMedium && b.facing / 2u == axis);
    if (!normal) key[6 + axis] = std::max(key[6 + axis], halves(a.high[axis] - b.high[axis]));
  }
  key[9] = static_cast<std::int16_t>(a.facing * 7 + b.facing);
  const auto [at, fresh] = known_.try_emplace(key);
  if (fresh) {
    AxisBox from{a.low, a.high, a.facing}, to{b.low, b.high, b.facing};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (AxisBox* box : {&from, &to}) box->low[axis] *= edges_[axis], box->high[axis] *= edges_[axis];
    }
    at->second.way = WayFactor(from, to);
  }
  Known& known = at->second;
  if (known.kappa != kappa) known.kappa = kappa, known.factor = known.way.at(kappa);
  return known.factor;
}

}  // namespace gicube::samples

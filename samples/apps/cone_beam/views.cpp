#include "cone_beam/geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gicube::samples {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kSame = 1e-6;  // chosen: radians, a thousandth of a pixel at the edge of a detector of thousands

// In [0, one turn); an angle just below a whole turn becomes 0.
double within_turn(double angle) {
  const double part = angle - kTurn * std::floor(angle / kTurn);
  return part > kTurn - kSame ? 0 : part;
}

}  // namespace

std::size_t SortedViews::repeated() const {
  std::size_t count = 0;
  for (const auto& list : places) count += list.size() - 1;
  return count;
}

SortedViews sorted_views(const std::vector<double>& angles) {
  SortedViews out;
  if (angles.empty()) return out;
  // Relative to the first of the list, which becomes the least. Whole turns are removed first, because many of them
  // would take most of the precision.
  const double first = std::fmod(angles[0], kTurn);
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    order.emplace_back(within_turn(std::fmod(angles[i], kTurn) - first), i);
  }
  std::ranges::stable_sort(order, {}, &std::pair<double, std::size_t>::first);
  for (const auto& [angle, place] : order) {
    if (out.angles.empty() || angle - out.angles.back() > kSame) {
      out.angles.push_back(angle);
      out.places.emplace_back();
    }
    out.places.back().push_back(place);
  }
  for (auto& places : out.places) std::ranges::sort(places);
  // The widest gap, behind which a short scan begins, and the second widest.
  const std::size_t count = out.angles.size();
  double widest = 0, second = 0;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double gap = i + 1 < count ? out.angles[i + 1] - out.angles[i] : kTurn - out.angles[i];
    if (gap > widest) {
      second = widest, widest = gap, begin = (i + 1) % count;
    } else {
      second = std::max(second, gap);
    }
  }
  if (widest > 2 * second) {
    std::rotate(out.angles.begin(), out.angles.begin() + static_cast<std::ptrdiff_t>(begin), out.angles.end());
    std::rotate(out.places.begin(), out.places.begin() + static_cast<std::ptrdiff_t>(begin), out.places.end());
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (out.angles[i] < out.angles[0] - kSame) out.angles[i] += kTurn;
  }
  for (double& angle : out.angles) angle += first;
  return out;
}

}  // namespace gicube::samples

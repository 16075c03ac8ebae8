#include "cone_beam/centre.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cone_beam/redundancy.h"
#include "gicube/error.h"
#include "gicube/parallel_for.h"

namespace gicube::samples {
namespace {

// Sums of a few rows per view, columns fastest.
struct Fan {
  const ConeGeometry& geometry;
  std::size_t columns;
  std::vector<double> values;

  // Interpolates between pixels of a view, by the parabola through three of them.
  double at(std::size_t view, double column) const {
    const double nearest = std::clamp(std::round(column), 1.0, static_cast<double>(columns) - 2), t = column - nearest;
    const double* const p = values.data() + view * columns + static_cast<std::size_t>(nearest);
    return p[0] + t * (p[1] - p[-1]) / 2 + t * t * (p[1] + p[-1] - 2 * p[0]) / 2;
  }

  // Squared difference between lines and their opposites at this offset, relative to their squares; infinite if there
  // are too few.
  double mismatch(double offset) const {
    const Detector& detector = geometry.detector;
    double off = 0, all = 0;
    std::size_t pairs = 0;
    for (std::size_t view = 0; view < geometry.angles.size(); ++view) {
      for (std::size_t column = 0; column < columns; ++column) {
        const double u = (static_cast<double>(column) - (detector.columns - 1) / 2.0) * detector.pitch_u + offset;
        const double other = (-u - offset) / detector.pitch_u + (detector.columns - 1) / 2.0;
        if (other < 0 || other > detector.columns - 1) continue;
        const auto [before, behind, part] = opposite_views(geometry, view, u);
        if (behind == 0 && is_short_scan(geometry)) continue;
        const double own = values[view * columns + column];
        const double opposite = (1 - part) * at(before, other) + part * at(behind, other);
        off += (own - opposite) * (own - opposite);
        all += own * own + opposite * opposite;
        ++pairs;
      }
    }
    constexpr double kFew = 0.01;  // chosen: of all lines
    const bool enough = static_cast<double>(pairs) > kFew * static_cast<double>(values.size()) && all > 0;
    return enough ? off / all : std::numeric_limits<double>::infinity();
  }
};

}  // namespace

double find_offset_u(const ConeGeometry& geometry, const Projections& projections) {
  check(geometry);
  check(projections, geometry);
  if (!geometry.circular()) {
    throw BadArgument("poses", "views on a circle, to find its centre", fmt::format("{} poses", geometry.poses.size()));
  }
  const Detector& detector = geometry.detector;
  const auto columns = static_cast<std::size_t>(detector.columns);
  expect(columns >= 3, "detector.columns", "at least 3", detector.columns);
  Fan fan{geometry, columns, std::vector<double>(columns * geometry.angles.size())};
  constexpr int kRows = 2;  // chosen: on both sides of the middle plane
  const int middle = static_cast<int>(std::lround((detector.rows - 1) / 2.0 - detector.offset_v / detector.pitch_v));
  const int first = std::clamp(middle - kRows, 0, detector.rows - 1),
            last = std::clamp(middle + kRows, 0, detector.rows - 1);
  for (std::size_t view = 0; view < geometry.angles.size(); ++view) {
    for (int row = first; row <= last; ++row) {
      const float* const from = projections.view(view) + static_cast<std::size_t>(row) * columns;
      for (std::size_t i = 0; i < columns; ++i) fan.values[view * columns + i] += double{from[i]};
    }
  }
  // Steps of whole pixels first, then finer ones around the best offset.
  double best = detector.offset_u, step = detector.pitch_u;
  int steps = std::max(2, detector.columns / 4);
  for (; step > 0.005 * detector.pitch_u; step /= 4, steps = 5) {
    std::vector<double> found(static_cast<std::size_t>(2 * steps + 1));
    const double from = best - steps * step;
    parallel_for(found.size(), 0,
                 [&](std::size_t i) { found[i] = fan.mismatch(from + static_cast<double>(i) * step); });
    const auto least = std::ranges::min_element(found);
    expect(std::isfinite(*least), "angles", "an arc in which lines are measured from both sides, of an object",
           arc_of(geometry));
    best = from + static_cast<double>(least - found.begin()) * step;
  }
  return best;
}

}  // namespace gicube::samples

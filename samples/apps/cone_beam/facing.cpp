#include "cone_beam/facing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "gicube/error.h"
#include "gicube/parallel_for.h"

namespace gicube::samples {
namespace {

// Interpolates between pixels by cubics along both axes; repeats the edge beyond the detector.
double value_at(const float* view, const Detector& detector, double column, double row) {
  const double left = std::floor(column), below = std::floor(row);
  const std::array<double, 4> across = cubic(column - left), up = cubic(row - below);
  const auto clamped = [](double place, int count) {
    return static_cast<std::size_t>(std::clamp(place, 0.0, count - 1.0));
  };
  double sum = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    const float* const line =
        view + clamped(below - 1 + static_cast<double>(j), detector.rows) * static_cast<std::size_t>(detector.columns);
    for (std::size_t i = 0; i < 4; ++i) {
      sum += up[j] * across[i] * double{line[clamped(left - 1 + static_cast<double>(i), detector.columns)]};
    }
  }
  return sum;
}

}  // namespace

std::array<double, 4> cubic(double t) {
  return {-t * (1 - t) * (1 - t) / 2, 1 + t * t * (3 * t - 5) / 2, t * (1 + t * (4 - 3 * t)) / 2, t * t * (t - 1) / 2};
}

FacingViews facing(const ConeGeometry& geometry, const Projections& projections) {
  check(geometry);
  check(projections, geometry);
  FacingViews out{circle_of(geometry), {projections.columns, projections.rows, {}}};
  ConeGeometry& circle = out.geometry;
  const Detector& detector = circle.detector;
  const double most = 0.5 * detector.pitch_u * circle.source_to_axis / circle.source_to_detector;
  for (std::size_t view = 0; view < geometry.poses.size(); ++view) {
    const double off = length(geometry.poses[view].source - pose(circle, view).source);
    if (off <= most) continue;
    throw BadArgument(fmt::format("poses[{}].source", view),
                      fmt::format("a place on the circle of radius {:.6g} about z in the middle plane, for fdk (sart, "
                                  "os-sart, sirt, cgls, osem and tv take any orbit)",
                                  circle.source_to_axis),
                      fmt::format("one {:.3g} off it", off));
  }
  const SortedViews order = sorted_views(circle.angles);
  circle.angles = order.angles;
  check(circle);
  const std::size_t size = projections.view_size();
  out.projections.values.resize(size * order.angles.size());
  parallel_for(order.angles.size(), 0, [&](std::size_t view) {
    const ViewPose ideal = pose(circle, view);
    const auto share = 1 / static_cast<float>(order.places[view].size());
    float* value = out.projections.view(view);
    for (int row = 0; row < detector.rows; ++row) {
      for (int column = 0; column < detector.columns; ++column, ++value) {
        const Vec3 pixel = ideal.centre + (column - (detector.columns - 1) / 2.0) * ideal.u +
                           (row - (detector.rows - 1) / 2.0) * ideal.v;
        for (const std::size_t place : order.places[view]) {
          const SeenAt at = seen_at(geometry.poses[place], pixel);
          if (!std::isfinite(at.column + at.row)) continue;
          *value += share * static_cast<float>(value_at(projections.view(place), detector,
                                                        at.column + (detector.columns - 1) / 2.0,
                                                        at.row + (detector.rows - 1) / 2.0));
        }
      }
    }
  });
  return out;
}

}  // namespace gicube::samples

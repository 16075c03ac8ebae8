#include "cone_beam/geometry.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string>

#include "gicube/error.h"

namespace gicube::samples {
namespace {

void expect_positive(const std::string& name, double value) {
  if (std::isfinite(value) && value > 0) return;
  throw BadArgument(name, "a finite number above 0", fmt::format("{}", value));
}

void expect_at_least(const std::string& name, int value, int least) {
  if (value < least) throw BadArgument(name, fmt::format("at least {}", least), std::to_string(value));
}

}  // namespace

void check(const ConeGeometry& geometry) {
  expect_positive("source_to_axis", geometry.source_to_axis);
  expect_positive("source_to_detector", geometry.source_to_detector);
  const Detector& detector = geometry.detector;
  expect_at_least("detector.columns", detector.columns, 2);
  expect_at_least("detector.rows", detector.rows, 1);
  expect_positive("detector.pitch_u", detector.pitch_u);
  expect_positive("detector.pitch_v", detector.pitch_v);
  for (const double offset : {detector.offset_u, detector.offset_v}) {
    if (!std::isfinite(offset)) throw BadArgument("detector.offset", "finite numbers", fmt::format("{}", offset));
  }
  const Vec3 spacing = geometry.volume.spacing;
  for (const double edge : {spacing.x, spacing.y, spacing.z}) expect_positive("volume.spacing", edge);
  for (const int dim : geometry.volume.dims) expect_at_least("volume.dims", dim, 2);
  if (geometry.angles.size() < 2) {
    throw BadArgument("angles", "at least 2", std::to_string(geometry.angles.size()));
  }
  for (std::size_t i = 0; i < geometry.angles.size(); ++i) {
    const double angle = geometry.angles[i];
    const bool ascends = i == 0 || angle > geometry.angles[i - 1];
    if (std::isfinite(angle) && ascends && angle - geometry.angles[0] < 2 * std::numbers::pi) continue;
    throw BadArgument(fmt::format("angles[{}]", i), "finite, ascending, within one turn", fmt::format("{}", angle));
  }
  const Vec3 corner = to_space(geometry.volume, {0, 0, 0});
  if (std::hypot(corner.x, corner.y) >= geometry.source_to_axis) {
    throw BadArgument("source_to_axis", "a source that goes round the volume",
                      fmt::format("{}", geometry.source_to_axis));
  }
}

void check(const Projections& projections, const ConeGeometry& geometry) {
  const std::size_t pixels = projections.view_size() * geometry.angles.size();
  if (projections.columns == geometry.detector.columns && projections.rows == geometry.detector.rows &&
      projections.values.size() == pixels) {
    return;
  }
  throw BadArgument(
      "projections", "a view of the detector's size for each angle",
      fmt::format("{} x {}, {} values", projections.columns, projections.rows, projections.values.size()));
}

std::vector<double> even_angles(int views, double first, double arc) {
  std::vector<double> angles;
  const bool whole = arc > 2 * std::numbers::pi * (1 - 1e-9);
  for (int i = 0; i < views; ++i) angles.push_back(first + arc * i / (whole ? views : std::max(views - 1, 1)));
  return angles;
}

Pose pose(const ConeGeometry& geometry, double angle) {
  const Vec3 out{std::cos(angle), std::sin(angle), 0};
  return {geometry.source_to_axis * out,
          (geometry.source_to_axis - geometry.source_to_detector) * out,
          {-out.y, out.x, 0},
          {0, 0, 1}};
}

}  // namespace gicube::samples

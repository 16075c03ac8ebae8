#include "cone_beam/geometry.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "gicube/error.h"

namespace gicube::samples {

void expect(bool good, const std::string& field, const std::string& expected, double got) {
  if (!good) throw BadArgument(field, expected, fmt::format("{}", got));
}

void check(const ConeGeometry& geometry) {
  const Detector& detector = geometry.detector;
  const Grid& grid = geometry.volume;
  for (const auto& [field, value] : {std::pair{"source_to_axis", geometry.source_to_axis},
                                     {"source_to_detector", geometry.source_to_detector},
                                     {"detector.pitch_u", detector.pitch_u},
                                     {"detector.pitch_v", detector.pitch_v},
                                     {"volume.spacing", grid.spacing.x},
                                     {"volume.spacing", grid.spacing.y},
                                     {"volume.spacing", grid.spacing.z}}) {
    expect(std::isfinite(value) && value > 0, field, "a finite number above 0", value);
  }
  expect(detector.columns >= 2, "detector.columns", "at least 2", detector.columns);
  expect(detector.rows >= 1, "detector.rows", "at least 1", detector.rows);
  for (const double offset : {detector.offset_u, detector.offset_v}) {
    expect(std::isfinite(offset), "detector.offset", "finite numbers", offset);
  }
  for (const int dim : grid.dims) expect(dim >= 2, "volume.dims", "at least 2", dim);
  const auto& angles = geometry.angles;
  expect(angles.size() >= 2, "angles", "at least 2", static_cast<double>(angles.size()));
  const auto count = [](const auto& list) { return static_cast<double>(list.size()); };
  if (!geometry.circular()) {
    expect(count(geometry.poses) == count(angles), "poses", fmt::format("{}, one an angle", count(angles)),
           count(geometry.poses));
    return;  // the projector checks each
  }
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const bool ascends = i == 0 || angles[i] > angles[i - 1];
    expect(std::isfinite(angles[i]) && ascends && angles[i] - angles[0] < 2 * std::numbers::pi,
           fmt::format("angles[{}]", i), "finite, ascending, within one turn", angles[i]);
  }
  const Vec3 corner = to_space(grid, {0, 0, 0});
  expect(std::hypot(corner.x, corner.y) < geometry.source_to_axis, "source_to_axis",
         "a source that goes round the volume", geometry.source_to_axis);
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

ViewPose pose(const ConeGeometry& geometry, std::size_t view) {
  if (!geometry.circular()) return geometry.poses[view];
  const Detector& detector = geometry.detector;
  const double c = std::cos(geometry.angles[view]), s = std::sin(geometry.angles[view]);
  const Vec3 out{c, s, 0}, along_u{-s, c, 0}, along_v{0, 0, 1};
  return {geometry.source_to_axis * out,
          (geometry.source_to_axis - geometry.source_to_detector) * out + detector.offset_u * along_u +
              detector.offset_v * along_v,
          detector.pitch_u * along_u, detector.pitch_v * along_v};
}

}  // namespace gicube::samples

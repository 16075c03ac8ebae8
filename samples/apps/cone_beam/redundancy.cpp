#include "cone_beam/redundancy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gicube/error.h"

namespace gicube::samples {
namespace {

using std::numbers::pi;

constexpr double kDisplaced = 0.01;  // chosen: of the detector's width
double width_of(const Detector& detector) { return detector.columns * detector.pitch_u; }

// Rises smoothly from 0 at 0 to 1 at 2.
double smooth(double part) {
  const double s = std::sin(pi / 4 * part);
  return s * s;
}

// Number of columns that the near side misses.
int missing_columns(const Detector& detector, bool displaced) {
  return displaced ? static_cast<int>(std::lround(2 * std::abs(detector.offset_u) / detector.pitch_u)) : 0;
}

}  // namespace

double arc_of(const ConeGeometry& geometry) {
  const auto& angles = geometry.angles;
  return (angles.back() - angles.front()) * static_cast<double>(angles.size()) / static_cast<double>(angles.size() - 1);
}

bool is_short_scan(const ConeGeometry& geometry) { return arc_of(geometry) < 2 * pi * 0.999; }

std::vector<double> arc_weights(const ConeGeometry& geometry) {
  const auto& angles = geometry.angles;
  const std::size_t count = angles.size();
  const bool whole = !is_short_scan(geometry);
  std::vector<double> weights(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double before = i > 0 ? angles[i] - angles[i - 1] : whole ? angles[0] + 2 * pi - angles[count - 1] : 0;
    const double behind = i + 1 < count ? angles[i + 1] - angles[i] : whole ? angles[0] + 2 * pi - angles[i] : 0;
    weights[i] = (before + behind) / 2 * (whole ? 0.5 : 1);
  }
  return weights;
}

double short_scan_weight(double angle, double fan, double arc) {
  const double beyond = (arc - pi) / 2;  // the largest fan angle that the arc serves
  if (angle < 0 || angle > arc) return 0;
  const double rise = 2 * (beyond - fan), fall = 2 * (beyond + fan);  // angles of the first and the last such views
  if (rise > 0 && angle < rise) return smooth(2 * angle / rise);
  if (fall > 0 && angle > arc - fall) return smooth(2 * (arc - angle) / fall);
  return 1;
}

ConeGeometry widened(const ConeGeometry& geometry, bool displaced) {
  ConeGeometry out = geometry;
  Detector& detector = out.detector;
  const int missing = missing_columns(detector, displaced);
  detector.columns += missing;
  detector.offset_u -= std::copysign(missing * detector.pitch_u / 2, detector.offset_u);
  return out;
}

WeightedRows::WeightedRows(const ConeGeometry& geometry, bool displaced)
    : geometry_(geometry), short_scan_(is_short_scan(geometry)), displaced_(displaced) {
  const Detector& detector = geometry.detector;
  const int missing = missing_columns(detector, displaced);
  columns_ = detector.columns + missing;
  far_ = detector.offset_u < 0 ? -1 : 1;
  first_ = far_ > 0 ? missing : 0;
  near_ = (detector.columns - 1) / 2.0 * detector.pitch_u - std::abs(detector.offset_u);
  reach_ = near_ + 2 * std::abs(detector.offset_u);
}

OppositeViews opposite_views(const ConeGeometry& geometry, std::size_t view, double u) {
  const auto& angles = geometry.angles;
  const double turn = 2 * pi, angle = angles[view] + pi - 2 * std::atan(u / geometry.source_to_detector);
  const double wanted = angles[0] + std::fmod(std::fmod(angle - angles[0], turn) + turn, turn);
  const auto above = static_cast<std::size_t>(std::ranges::upper_bound(angles, wanted) - angles.begin());
  const std::size_t before = above - 1, behind = above == angles.size() ? 0 : above;
  const double gap = (behind == 0 ? angles[0] + turn : angles[behind]) - angles[before];
  return {before, behind, (wanted - angles[before]) / gap};
}

// In the same row, both lines cross the plane through the axis that is perpendicular to them at the same height.
double WeightedRows::from_opposite(const Projections& projections, std::size_t view, int row, double u) const {
  const Detector& detector = geometry_.detector;
  const auto [before, behind, part] = opposite_views(geometry_, view, u);
  const double column = std::clamp((-u - detector.offset_u) / detector.pitch_u + (detector.columns - 1) / 2.0, 0.0,
                                   detector.columns - 1.0);
  const auto left = std::min(static_cast<std::size_t>(column), static_cast<std::size_t>(detector.columns) - 2);
  const double beyond = column - static_cast<double>(left);
  const std::size_t start = static_cast<std::size_t>(row) * static_cast<std::size_t>(detector.columns) + left;
  const auto in_view = [&](std::size_t i) {
    const float* const value = projections.view(i) + start;
    return (1 - beyond) * double{value[0]} + beyond * double{value[1]};
  };
  return (1 - part) * in_view(before) + part * in_view(behind);
}

void WeightedRows::row(const Projections& projections, std::size_t view, int row, double* out) const {
  const Detector& detector = geometry_.detector;
  const double distance = geometry_.source_to_detector;
  const double after = geometry_.angles[view] - geometry_.angles.front();
  const double whole = geometry_.angles.back() - geometry_.angles.front();
  const float* const from =
      projections.view(view) + static_cast<std::size_t>(row) * static_cast<std::size_t>(detector.columns);
  for (int i = 0; i < columns_; ++i) {
    const int column = i - first_;
    const double u = u_of(detector, column), toward_far = far_ * u;
    const bool measured = column >= 0 && column < detector.columns;
    double value = measured ? double{from[column]} : 0;
    if (short_scan_) value *= short_scan_weight(after, -std::atan(u / distance), whole);
    if (displaced_) {
      const double weight =
          2 * smooth(1 + std::clamp(std::atan(toward_far / distance) / std::atan(reach_ / distance), -1.0, 1.0));
      if (toward_far < 0) {
        // Fades from the measured values to those of the opposite views over the near side.
        const double own = measured ? std::clamp(1 + toward_far / near_, 0.0, 1.0) : 0;
        value = own * value + (1 - own) * from_opposite(projections, view, row, u);
      }
      value *= weight;
    }
    out[i] = value;
  }
}

SidesSeen sides_seen(const Projections& projections) {
  std::vector<double> sums(static_cast<std::size_t>(projections.columns));
  for (auto value = projections.values.begin(); value != projections.values.end();) {
    for (double& sum : sums) sum += static_cast<double>(*value++);
  }
  const double most = std::ranges::max(sums);
  if (!(most > 0)) return {};
  return {sums.front() / most, sums.back() / most, std::ranges::min(sums) / most};
}

bool is_displaced(const ConeGeometry& geometry, const Projections& projections) {
  const Detector& detector = geometry.detector;
  const double half = (detector.columns - 1) / 2.0 * detector.pitch_u, offset = std::abs(detector.offset_u);
  expect(offset < half, "detector.offset_u",
         fmt::format("within {:g} of 0, so that the ray through the axis meets the detector", half), detector.offset_u);
  const SidesSeen seen = sides_seen(projections);
  const double near = detector.offset_u > 0 ? seen.first : seen.last;
  if (offset <= kDisplaced * width_of(detector) || near < SidesSeen::kSeen) return false;
  if (!is_short_scan(geometry)) return true;
  throw BadArgument("angles",
                    fmt::format("a whole turn: the detector is displaced (offset_u {:g}) and the object reaches beyond "
                                "its near side, where opposite views are needed; iterative methods may do without",
                                detector.offset_u),
                    fmt::format("{:.1f} degrees", arc_of(geometry) * 180 / pi));
}

}  // namespace gicube::samples

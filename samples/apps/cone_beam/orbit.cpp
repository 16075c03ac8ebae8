// Views on any orbit, and the circle nearest to them.
#include <algorithm>
#include <cmath>
#include <limits>

#include "cone_beam/geometry.h"

namespace gicube::samples {

SeenAt seen_at(const ViewPose& view, Vec3 place) {
  const Vec3 normal = cross(view.u, view.v), way = place - view.source;
  const double toward = dot(way, normal), part = dot(view.centre - view.source, normal) / toward;
  if (!(part > 0)) return {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  // Position on the detector in units of u and v, which need not be perpendicular.
  const Vec3 on = view.source + part * way - view.centre;
  const double square = dot(normal, normal);
  return {dot(cross(on, view.v), normal) / square, dot(cross(view.u, on), normal) / square};
}

ConeGeometry circle_of(const ConeGeometry& geometry) {
  ConeGeometry out = geometry;
  out.poses.clear();
  out.angles.clear();
  double to_axis = 0, to_detector = 0, pitch_u = 0, pitch_v = 0, offset_u = 0, offset_v = 0;
  for (const ViewPose& view : geometry.poses) {
    const double angle = std::atan2(view.source.y, view.source.x);
    const Vec3 inwards{-std::cos(angle), -std::sin(angle), 0}, normal = cross(view.u, view.v);
    const SeenAt axis = seen_at(view, view.source + inwards);
    out.angles.push_back(angle);
    to_axis += std::hypot(view.source.x, view.source.y);
    to_detector += dot(view.centre - view.source, normal) / dot(inwards, normal);
    pitch_u += length(view.u);
    pitch_v += length(view.v);
    offset_u -= axis.column * length(view.u);
    offset_v -= axis.row * length(view.v);
  }
  const auto count = static_cast<double>(geometry.poses.size());
  out.source_to_axis = to_axis / count;
  out.source_to_detector = to_detector / count;
  out.detector.pitch_u = pitch_u / count;
  out.detector.pitch_v = pitch_v / count;
  out.detector.offset_u = offset_u / count;
  out.detector.offset_v = offset_v / count;
  return out;
}

double off_circle(const ConeGeometry& geometry, const ConeGeometry& circle, std::size_t view) {
  const Detector& detector = circle.detector;
  const double at_axis = circle.source_to_axis / circle.source_to_detector;
  const double reach = detector.columns / 2.0 * detector.pitch_u + std::abs(detector.offset_u);
  const double radius = circle.source_to_axis * std::sin(std::atan(reach / circle.source_to_detector));
  const double height = detector.rows / 2.0 * detector.pitch_v * at_axis;
  const ViewPose own = pose(geometry, view), ideal = pose(circle, view);
  double most = 0;
  for (const double x : {-radius, radius}) {
    for (const double z : {-height, 0.0, height}) {
      for (const Vec3 place : {Vec3{x, 0, z}, Vec3{0, x, z}}) {
        const SeenAt a = seen_at(own, place), b = seen_at(ideal, place);
        const double off = std::hypot(a.column - b.column, a.row - b.row);
        most = std::isfinite(off) ? std::max(most, off) : std::numeric_limits<double>::infinity();
      }
    }
  }
  return most;
}

}  // namespace gicube::samples

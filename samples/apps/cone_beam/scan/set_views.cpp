// Sets the views of a scan's file, as a circle if they are on one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cone_beam/scan/formats.h"

namespace gicube::samples {

std::string in_brackets(Vec3 v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x, v.y, v.z); }

void check_view(const ViewPose& view, const std::filesystem::path& file, const std::string& name) {
  const auto finite = [](Vec3 v) { return std::isfinite(v.x + v.y + v.z); };
  expect(finite(view.source) && finite(view.centre), file, name, "finite places",
         in_brackets(view.source) + " and " + in_brackets(view.centre));
  const Vec3 normal = cross(view.u, view.v);
  const double size = length(view.u) * length(view.v);
  expect(std::isfinite(size) && size > 0 && length(normal) > 1e-6 * size, file, name,
         "steps between pixels in two directions", in_brackets(view.u) + " and " + in_brackets(view.v));
  expect(std::abs(dot(view.centre - view.source, normal)) > 1e-9 * length(normal) * length(view.source - view.centre),
         file, name, "a source that is not in its detector's plane", in_brackets(view.source));
}

void set_views(std::vector<ViewPose> views, Vec3 axis, ScanDescription& description,
               std::optional<double> given_height) {
  constexpr double kPixels = 0.05;  // chosen: that views of a circle may be off it
  ConeGeometry& geometry = description.geometry;
  double height = 0;
  for (const ViewPose& view : views) height += view.source.z / static_cast<double>(views.size());
  description.centre = {axis.x, axis.y, given_height.value_or(height)};
  // Directions of rows and columns as on a circle, by the first view.
  const ViewPose first = views.front();
  const Vec3 source = first.source - description.centre;
  description.columns_reversed = dot(first.u, Vec3{-source.y, source.x, 0}) < 0;
  description.rows_reversed = first.v.z < 0;
  for (ViewPose& view : views) {
    view = {view.source - description.centre, view.centre - description.centre,
            (description.columns_reversed ? -1.0 : 1.0) * view.u, (description.rows_reversed ? -1.0 : 1.0) * view.v};
  }
  geometry.poses = std::move(views);
  ConeGeometry circle = circle_of(geometry);
  geometry.angles = circle.angles;
  const auto on_circle = [&](std::size_t i) { return off_circle(geometry, circle, i) < kPixels; };
  bool circular = circle.source_to_axis > 0 && circle.source_to_detector > 0;
  for (std::size_t i = 0; circular && i < geometry.poses.size(); ++i) circular = on_circle(i);
  const Grid volume = geometry.volume;
  if (circular) {
    geometry = std::move(circle);
    geometry.volume = volume;
    return;
  }
  // Means, which give the size of voxels.
  const auto count = static_cast<double>(geometry.poses.size());
  geometry.source_to_axis = geometry.source_to_detector = 0;
  Detector& detector = geometry.detector;
  detector.pitch_u = detector.pitch_v = 0;
  for (const ViewPose& view : geometry.poses) {
    const Vec3 normal = cross(view.u, view.v);
    const double to_detector = std::abs(dot(view.centre - view.source, normal)) / length(normal);
    const double to_middle = length(view.source);
    geometry.source_to_axis += (to_middle > 0 ? to_middle : to_detector) / count;
    geometry.source_to_detector += to_detector / count;
    detector.pitch_u += length(view.u) / count;
    detector.pitch_v += length(view.v) / count;
  }
}

ScanDescription scan_of(std::vector<ViewPose> views, const Pixels& pixels, const std::filesystem::path& file,
                        const StackFiles& projections) {
  ScanDescription out;
  out.file = file;
  out.projections = projections;
  out.geometry.detector.columns = pixels.columns;
  out.geometry.detector.rows = pixels.rows;
  set_views(std::move(views), {}, out);
  return out;
}

}  // namespace gicube::samples

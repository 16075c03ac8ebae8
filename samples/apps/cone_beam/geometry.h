// Positions of source, detector and volume in cone-beam tomography. Lengths have one unit that the caller chooses, such
// as millimetres; angles are in radians. The origin is the middle of the volume.
//
// On a circle the axis of rotation is z. At angle b the source is at source_to_axis (cos b, sin b, 0). The detector is
// perpendicular to the ray through the axis, source_to_detector away from the source; its columns run along (-sin b,
// cos b, 0) and its rows along z. Any other orbit has a pose per view. docs/guide/cone_beam_geometry.md draws both.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "gicube/projector.h"
#include "gicube/vector.h"

namespace gicube::samples {

struct Detector {
  int columns = 0;      // at least 2
  int rows = 0;         // at least 1
  double pitch_u = 1;   // between columns; > 0
  double pitch_v = 1;   // between rows; > 0
  double offset_u = 0;  // from the ray through the axis to the detector's middle
  double offset_v = 0;
};

struct Grid {
  Dims dims{};  // voxels
  Vec3 spacing{1, 1, 1};
};

struct ConeGeometry {
  double source_to_axis = 0;      // > 0
  double source_to_detector = 0;  // > 0
  Detector detector;
  Grid volume;
  std::vector<double> angles;  // at least 2; on a circle ascending, within one turn
  // Poses of views that are not on a circle, one per angle; the angles are then the sources', in any order. Distances
  // and pitches are those of the mean view, for defaults; offsets are not used.
  std::vector<ViewPose> poses{};

  bool circular() const { return poses.empty(); }
};

// Throws BadArgument with the field's name unless `good`.
void expect(bool good, const std::string& field, const std::string& expected, double got);
// Throws BadArgument with the field's name.
void check(const ConeGeometry& geometry);

// `views` angles from `first` on, uniform over `arc` (2 pi: the last differs from the first).
std::vector<double> even_angles(int views, double first, double arc);

// Source and detector of a view.
ViewPose pose(const ConeGeometry& geometry, std::size_t view);

// Position of a place on a view's detector: pixels from its middle. Not finite for a place beside the source.
struct SeenAt {
  double column = 0, row = 0;
};
SeenAt seen_at(const ViewPose& view, Vec3 place);

// The circle nearest to views with their own poses whose sources turn about z: mean distances, pitches and offsets, and
// the sources' angles in the order of the views. Columns must run as on a circle.
ConeGeometry circle_of(const ConeGeometry& geometry);
// Greatest distance, in pixels, between the positions of a place in a view and in the circle's view, over the field of
// `circle`.
double off_circle(const ConeGeometry& geometry, const ConeGeometry& circle, std::size_t view);

// Angles in the order of a ConeGeometry.
struct SortedViews {
  std::vector<double> angles;                    // ascending within one turn
  std::vector<std::vector<std::size_t>> places;  // of each angle in the given list: several if it is repeated

  std::size_t repeated() const;  // number of places beyond the first of their angle
};
// Angles that differ by whole turns are one [C: to 1e-6]. If one gap between angles is more than twice as wide as the
// second widest [C], as in a short scan, they begin behind it; else with the first of the list. `angles`: finite.
SortedViews sorted_views(const std::vector<double>& angles);

// Coordinates on the detector; pixels have whole numbers.
inline double u_of(const Detector& detector, double column) {
  return (column - (detector.columns - 1) / 2.0) * detector.pitch_u + detector.offset_u;
}
inline double v_of(const Detector& detector, double row) {
  return (row - (detector.rows - 1) / 2.0) * detector.pitch_v + detector.offset_v;
}

// The place of a voxel; its coordinates may be fractions.
inline Vec3 to_space(const Grid& grid, Vec3 voxel) {
  return {(voxel.x - (grid.dims[0] - 1) / 2.0) * grid.spacing.x, (voxel.y - (grid.dims[1] - 1) / 2.0) * grid.spacing.y,
          (voxel.z - (grid.dims[2] - 1) / 2.0) * grid.spacing.z};
}
inline Vec3 to_voxels(const Grid& grid, Vec3 place) {
  return {place.x / grid.spacing.x + (grid.dims[0] - 1) / 2.0, place.y / grid.spacing.y + (grid.dims[1] - 1) / 2.0,
          place.z / grid.spacing.z + (grid.dims[2] - 1) / 2.0};
}

inline std::size_t voxel_count(const Dims& dims) {
  return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(dims[2]);
}
// Calls visit(place) for the centres of a slice's voxels, x fastest.
template <typename Visit>
void for_each_in_slice(const Grid& grid, std::size_t z, const Visit& visit) {
  for (int y = 0; y < grid.dims[1]; ++y) {
    for (int x = 0; x < grid.dims[0]; ++x) visit(to_space(grid, {double(x), double(y), double(z)}));
  }
}

// Number of rays per pixel along each axis of the detector, at equal distances.
struct PixelRays {
  int u = 1, v = 1;
  friend bool operator==(const PixelRays&, const PixelRays&) = default;
};
// Calls visit(u, v) for all rays, rows first.
template <typename Visit>
void for_each_ray(const Detector& detector, PixelRays rays, const Visit& visit) {
  for (int j = 0; j < detector.rows * rays.v; ++j) {
    const double v = v_of(detector, (j + 0.5) / rays.v - 0.5);
    for (int i = 0; i < detector.columns * rays.u; ++i) visit(u_of(detector, (i + 0.5) / rays.u - 0.5), v);
  }
}
// Cosine of the angle between the ray to (u, v) and the detector's normal.
inline double slant(double source_to_detector, double u, double v) {
  return source_to_detector / std::sqrt(source_to_detector * source_to_detector + u * u + v * v);
}

// Projections of a scan: by views, then rows, columns fastest.
struct Projections {
  int columns = 0, rows = 0;
  std::vector<float> values;  // line integrals

  std::size_t view_size() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  const float* view(std::size_t i) const { return values.data() + i * view_size(); }
  float* view(std::size_t i) { return values.data() + i * view_size(); }
};

// Throws BadArgument unless each angle has a view of the detector's size.
void check(const Projections& projections, const ConeGeometry& geometry);

}  // namespace gicube::samples

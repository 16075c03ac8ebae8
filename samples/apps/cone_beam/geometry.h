// Where source, detector and volume stand in cone-beam tomography. Lengths in one unit of the caller's, say
// millimetres; angles in radians. The volume's middle is the origin.
//
// On a circle the axis of rotation is z. At angle b the source stands at source_to_axis (cos b, sin b, 0); a detector
// that faces it squarely lies source_to_detector away from it, its columns run along (-sin b, cos b, 0) and its rows
// along z. Any other orbit has a pose for each view. docs/guide/cone_beam_geometry.md draws both.
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
  double offset_u = 0;  // of the detector's middle from the ray through the axis
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
  // Poses of views that do not lie on a circle, one per angle, which are then the sources' in any order. Distances and
  // pitches are those of the mean view, for defaults; offsets are not used.
  std::vector<ViewPose> poses{};

  bool circular() const { return poses.empty(); }
};

// Throws BadArgument that names the field unless `good`.
void expect(bool good, const std::string& field, const std::string& expected, double got);
// Throws BadArgument naming the field.
void check(const ConeGeometry& geometry);

// `views` angles from `first` on, evenly over `arc` (2 pi: the last is not the first).
std::vector<double> even_angles(int views, double first, double arc);

// One view's source and detector in space.
ViewPose pose(const ConeGeometry& geometry, std::size_t view);

// Where a view sees a place: pixels from the detector's middle. Not finite for a place beside its source.
struct SeenAt {
  double column = 0, row = 0;
};
SeenAt seen_at(const ViewPose& view, Vec3 place);

// The circle nearest to views with poses of their own whose sources go round z: mean distances, pitches and offsets,
// and the angles of the sources, in the order of the views. Columns have to run as on a circle.
ConeGeometry circle_of(const ConeGeometry& geometry);
// By how many pixels at most a view sees places in the field of `circle` elsewhere than a view of the circle does.
double off_circle(const ConeGeometry& geometry, const ConeGeometry& circle, std::size_t view);

// Angles as a ConeGeometry wants them.
struct SortedViews {
  std::vector<double> angles;                    // ascending within one turn
  std::vector<std::vector<std::size_t>> places;  // of each angle, in the list that came: several where it was repeated

  std::size_t repeated() const;  // places beyond the first of their angle
};
// Angles a whole number of turns apart are one [C: to 1e-6]. Where the angles leave a gap that is more than twice their
// second widest [C], as in a short scan, they begin behind it; else with the first of the list. `angles`: finite.
SortedViews sorted_views(const std::vector<double>& angles);

// Coordinates of pixel centres; whole numbers are pixels.
inline double u_of(const Detector& detector, double column) {
  return (column - (detector.columns - 1) / 2.0) * detector.pitch_u + detector.offset_u;
}
inline double v_of(const Detector& detector, double row) {
  return (row - (detector.rows - 1) / 2.0) * detector.pitch_v + detector.offset_v;
}

// The place of a voxel, whose numbers need not be whole.
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

// The number of rays of a pixel along each axis of the detector, evenly spaced.
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
// The cosine of the angle between the ray to (u, v) and the one that meets the detector squarely.
inline double slant(double source_to_detector, double u, double v) {
  return source_to_detector / std::sqrt(source_to_detector * source_to_detector + u * u + v * v);
}

// Projections of a scan: view by view, row by row, columns fastest.
struct Projections {
  int columns = 0, rows = 0;
  std::vector<float> values;  // line integrals

  std::size_t view_size() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  const float* view(std::size_t i) const { return values.data() + i * view_size(); }
  float* view(std::size_t i) { return values.data() + i * view_size(); }
};

// Throws BadArgument unless there is a view of the detector's size for each angle.
void check(const Projections& projections, const ConeGeometry& geometry);

}  // namespace gicube::samples

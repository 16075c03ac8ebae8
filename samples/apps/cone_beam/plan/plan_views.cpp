// Parts of scans for pilots.
#include "cone_beam/plan/plan.h"

#include <algorithm>
#include <cmath>

#include "cone_beam/fdk.h"

namespace gicube::samples {

ConeGeometry some_views(const ConeGeometry& geometry, int every) {
  ConeGeometry some = geometry;
  some.angles.clear();
  for (std::size_t i = 0; i < geometry.angles.size(); i += static_cast<std::size_t>(every)) {
    some.angles.push_back(geometry.angles[i]);
  }
  return some;
}

Projections some_views(const Projections& projections, std::size_t views, int every) {
  Projections some{projections.columns, projections.rows, {}};
  for (std::size_t i = 0; i < views; i += static_cast<std::size_t>(every)) {
    some.values.insert(some.values.end(), projections.view(i), projections.view(i) + projections.view_size());
  }
  return some;
}

FieldOfView field_seen(const ConeGeometry& geometry, bool displaced) {
  const Detector detector = widened(geometry, displaced).detector;
  const double wide = 0.5 * (detector.columns - 1) * detector.pitch_u - std::abs(detector.offset_u);
  const double high = 0.5 * (detector.rows - 1) * detector.pitch_v - std::abs(detector.offset_v);
  const Grid& grid = geometry.volume;
  const double radius =
      std::min({geometry.source_to_axis * std::sin(std::atan(std::max(0.0, wide) / geometry.source_to_detector)),
                0.5 * (grid.dims[0] - 1) * grid.spacing.x, 0.5 * (grid.dims[1] - 1) * grid.spacing.y});
  const double height = std::max(0.0, high) * (geometry.source_to_axis - radius) / geometry.source_to_detector;
  return {radius, std::min(height, 0.5 * (grid.dims[2] - 1) * grid.spacing.z)};
}

std::vector<int> strides_of(const ConeGeometry& geometry, int max_stride) {
  const auto views = static_cast<int>(geometry.angles.size());
  const int steps = is_short_scan(geometry) ? views - 1 : views;
  std::vector<int> strides;
  for (int every = 2; every <= max_stride && steps / every >= 8; ++every) {
    if (steps % every == 0) strides.push_back(every);
  }
  return strides;
}

Slab slab_of(const ConeGeometry& geometry, const Projections& projections, int slices) {
  Slab slab{geometry, {projections.columns, 0, {}}};
  Grid& grid = slab.geometry.volume;
  grid.dims[2] = std::min(slices, grid.dims[2]);
  grid.dims[2] -= (geometry.volume.dims[2] - grid.dims[2]) % 2;  // so that its voxels are voxels of the volume
  const double height = 0.5 * (grid.dims[2] - 1) * grid.spacing.z;
  const double half_diagonal =
      0.5 * std::hypot((grid.dims[0] - 1) * grid.spacing.x, (grid.dims[1] - 1) * grid.spacing.y);
  const double nearest = std::max(0.05 * geometry.source_to_axis, geometry.source_to_axis - half_diagonal);
  constexpr int kBeyond = 3;  // rows, for interpolation between them
  const Detector& all = geometry.detector;
  const double most = height * geometry.source_to_detector / nearest + kBeyond * all.pitch_v;
  int first = 0, last = all.rows - 1;
  while (first < last && v_of(all, first) < -most) ++first;
  while (last > first && v_of(all, last) > most) --last;
  Detector& rows = slab.geometry.detector;
  rows.rows = slab.projections.rows = last - first + 1;
  rows.offset_v = 0.5 * (v_of(all, first) + v_of(all, last));
  const auto columns = static_cast<std::size_t>(projections.columns);
  for (std::size_t view = 0; view < geometry.angles.size(); ++view) {
    const float* const from = projections.view(view);
    slab.projections.values.insert(slab.projections.values.end(), from + columns * static_cast<std::size_t>(first),
                                   from + columns * static_cast<std::size_t>(last + 1));
  }
  return slab;
}

}  // namespace gicube::samples

#include "cone_beam/view_rays.h"

#include <algorithm>
#include <array>

#include "cone_beam/parallel_for.h"

namespace gicube::samples {

HostRay clipped_ray(const Grid& grid, Vec3 source, Vec3 pixel) {
  const Vec3 from = to_voxels(grid, source), way = to_voxels(grid, pixel) - from;
  const std::array<double, 3> start{from.x, from.y, from.z}, along{way.x, way.y, way.z};
  double first = 0, last = 1e30;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double end = grid.dims[axis] - 1;
    if (along[axis] == 0) {
      if (start[axis] < 0 || start[axis] > end) return {};
      continue;
    }
    const double one = -start[axis] / along[axis], other = (end - start[axis]) / along[axis];
    first = std::max(first, std::min(one, other));
    last = std::min(last, std::max(one, other));
  }
  if (last <= first) return {};
  const auto within = [&](double value, std::size_t axis) { return std::clamp(value, 0.0, grid.dims[axis] - 1.0); };
  const Vec3 entry = from + first * way;
  return {.position = {within(entry.x, 0), within(entry.y, 1), within(entry.z, 2)},
          .direction = way,
          .length = (last - first) * length(way)};
}

std::vector<HostRay> view_rays(const ConeGeometry& geometry, double angle, int fine) {
  const Detector& detector = geometry.detector;
  const Pose at = pose(geometry, angle);
  const auto columns = static_cast<std::size_t>(detector.columns * fine);
  const auto rows = static_cast<std::size_t>(detector.rows * fine);
  std::vector<HostRay> rays(rows * columns);
  parallel_for(rows, [&](std::size_t row) {
    const double v = v_of(detector, (static_cast<double>(row) + 0.5) / fine - 0.5);
    for (std::size_t column = 0; column < columns; ++column) {
      const double u = u_of(detector, (static_cast<double>(column) + 0.5) / fine - 0.5);
      rays[row * columns + column] =
          clipped_ray(geometry.volume, at.source, at.middle + u * at.along_u + v * at.along_v);
    }
  });
  return rays;
}

double length_in_space(const Grid& grid, const HostRay& ray) {
  if (ray.length <= 0) return 0;
  const Vec3 along = ray.direction, edge = grid.spacing;
  return ray.length * length(Vec3{along.x * edge.x, along.y * edge.y, along.z * edge.z}) / length(along);
}

}  // namespace gicube::samples

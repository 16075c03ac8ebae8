#include "cone_beam/view_rays.h"

#include "cone_beam/backprojector.h"
#include "cone_beam/threads.h"

namespace gicube::samples {

std::vector<HostRay> view_rays(const ConeGeometry& geometry, double angle, int fine) {
  const Detector& detector = geometry.detector;
  const Pose at = pose(geometry, angle);
  const auto columns = static_cast<std::size_t>(detector.columns * fine);
  const auto rows = static_cast<std::size_t>(detector.rows * fine);
  std::vector<HostRay> rays(rows * columns);
  in_parallel(rows, [&](std::size_t row) {
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

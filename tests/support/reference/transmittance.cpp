#include "transmittance.h"

#include <cmath>

#include "classify.h"

namespace gicube::reference {

double transmittance(const Scene& scene, const Field& field, Vec3 from, Vec3 to, double step) {
  const Vec3 way = to - from, spacing = field.spacing();
  const double voxels = length(way);
  if (voxels == 0) return 1;
  const auto steps = static_cast<long>(std::ceil(voxels / step));
  const double edges = length({way.x * spacing.x, way.y * spacing.y, way.z * spacing.z}) / static_cast<double>(steps);
  double depth = 0;  // optical
  for (long i = 0; i < steps; ++i) {
    const Vec3 at = from + (static_cast<double>(i) + 0.5) / static_cast<double>(steps) * way;
    const TransferFunction& function = scene.functions[static_cast<std::size_t>(field.tag(at))];
    const double opacity = classify(function, field.sample(at), field.range(), {}).opacity;
    if (opacity >= 1) return 0;
    if (opacity > 0) depth -= std::log1p(-opacity) * edges;
  }
  return std::exp(-depth);
}

}  // namespace gicube::reference

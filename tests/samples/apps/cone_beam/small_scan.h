// A scan that is reconstructed in a second: the phantoms have a radius of at most 40, which the detector catches whole.
#pragma once

#include <numbers>

#include "cone_beam/geometry.h"

namespace gicube::samples {

inline ConeGeometry small_scan(int size, int views, double arc = 2 * std::numbers::pi) {
  ConeGeometry geometry;
  geometry.source_to_axis = 400;
  geometry.source_to_detector = 800;
  geometry.detector = {size, size, 200.0 / size, 200.0 / size};
  geometry.volume = {{size, size, size}, (90.0 / size) * Vec3{1, 1, 1}};
  geometry.angles = even_angles(views, 0.1, arc);
  return geometry;
}

}  // namespace gicube::samples

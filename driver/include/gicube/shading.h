// Local illumination by a distant light, as the reflectance map holds it [P §2.1, §3.4].
#pragma once

#include "gicube/vector.h"

namespace gicube {

// shade(normal) = ambient + diffuse max(N.L, 0) + specular s(N.L) max(R.V, 0)^shininess, R the reflected light
// direction, V towards the eye; s fades the highlight in over 0 <= N.L <= 0.1, so that the terminator has no hard edge.
// The part of a shade above ambient + diffuse is a highlight and goes to white. A sample without a gradient is not
// shaded.
struct Phong {
  double ambient = 0.25;  // each 0..1.99; ambient + diffuse at most 1.99, diffuse + specular at most 1.99
  double diffuse = 0.7;
  double specular = 0.35;
  double shininess = 24;  // 1..1000
};

struct Shading {  // local illumination by one light
  Phong phong{};
  // From the scene towards the light, physical axes (parallel to the voxel axes); any length but 0.
  // The zero vector stands for a head light: at the eye.
  Vec3 light{};
};

}  // namespace gicube

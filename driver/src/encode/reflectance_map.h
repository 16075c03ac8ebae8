// The reflectance map: Phong's local illumination by a distant light over all normals [P §3.4].
#pragma once

#include <cstdint>
#include <vector>

#include "gicube/shading.h"
#include "gicube/vector.h"

namespace gicube {

// Throw BadArgument naming the field and the bound that shading.h states.
void check(const Phong& phong);
void check(const Shading& shading);

// What a surface reflects beside the ambient part: diffuse max(N.L, 0) + specular s(N.L) max(R.V, 0)^shininess with
// R = 2 (N.L) N - L and s = N.L / 0.1 clamped to 0..1. `normal` and `towards_eye` are unit vectors; `light` has any
// length, and the zero vector stands for a light at the eye. All are physical.
double reflected(const Phong& phong, Vec3 normal, Vec3 light, Vec3 towards_eye);

// The map's bytes in the layout of lut.h: face, row, column; each reflected() of its texel's direction in 1/128,
// rounded and held to 255.
std::vector<std::uint8_t> reflectance_map(const Phong& phong, Vec3 light, Vec3 towards_eye);

}  // namespace gicube

// Vectors component by component, and as arrays.
#pragma once

#include <array>

#include "gicube/vector.h"

namespace gicube {

constexpr Vec3 times(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
constexpr Vec3 over(Vec3 a, Vec3 b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
constexpr std::array<double, 3> to_array(Vec3 v) { return {v.x, v.y, v.z}; }
constexpr Vec3 to_vec3(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace gicube

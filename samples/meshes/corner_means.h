// Values of triangles, smooth over a mesh.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "gicube/scene/mesh.h"
#include "scene/names.h"

namespace gicube::samples {

using TriangleValue = std::array<double, 3>;

// Of each triangle's corners: the mean, by area, over the triangles around it that face nearly alike (within 37 degrees).
std::vector<std::array<TriangleValue, 3>> corner_means(const Mesh& mesh, std::span<const TriangleValue> values);

// Between the corners of a triangle, at a place in its plane.
TriangleValue between_corners(const Mesh& mesh, std::size_t triangle, const std::array<TriangleValue, 3>& corners,
                              Vec3 place);

}  // namespace gicube::samples

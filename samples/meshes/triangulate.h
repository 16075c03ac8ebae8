// Triangles of shapes, and finer ones.
#pragma once

#include <array>

#include "gicube/scene/mesh.h"
#include "gicube/scene/shape.h"
#include "scene/names.h"

namespace gicube::samples {

std::array<Vec3, 3> corners_of(const Mesh& mesh, std::size_t triangle);
// To the side from which the corners are counter-clockwise.
Vec3 area_of(const Mesh& mesh, std::size_t triangle);

// Its rounding aside. Each side has corners of its own, so that nothing is smoothed over edges.
Mesh mesh_of(const BoxShape& box);

// Triangles cut in four until no edge is longer than `edge`; all as often as the longest edge needs. Texture coordinates are left out.
Mesh refined(const Mesh& mesh, double edge);

}  // namespace gicube::samples

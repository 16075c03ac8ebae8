// Closed meshes whose distances are known.
#pragma once

#include "gicube/scene/mesh.h"

namespace gicube::scene {

// The cube from -1 to 1: 8 points, 12 triangles.
Mesh cube_mesh();
// A unit icosahedron, each triangle cut in four `levels` times, all points on the unit sphere.
Mesh sphere_mesh(int levels);

}  // namespace gicube::scene

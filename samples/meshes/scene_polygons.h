// The solids of a scene that stay polygons: its boxes and meshes, which are taken out of the world before it becomes voxels.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "gicube/scene/mesh.h"
#include "gicube/scene/scene.h"
#include "meshes/triangulate.h"
#include "scene/names.h"

namespace gicube::samples {

struct PolygonSurface {
  std::string name;
  Mesh mesh;
  std::array<double, 3> albedo{};    // what both sides reflect
  std::array<double, 3> emission{};  // power that a unit of area sends out by itself, at its front
};

// In the scene's units. The nodes are groups without content from then on. Throws InputError that names the node: another solid, a
// material that is not diffuse or not opaque; FileError: of a mesh.
std::vector<PolygonSurface> take_polygons(Scene& scene);

// In another space, where no edge is longer than `edge`.
template <class Place>
void refine(std::vector<PolygonSurface>& surfaces, double edge, const Place& place) {
  for (PolygonSurface& surface : surfaces) {
    for (Vec3& point : surface.mesh.points) point = place(point);
    surface.mesh = refined(surface.mesh, edge);
  }
}

std::vector<Mesh> meshes_of(const std::vector<PolygonSurface>& surfaces);

// Whether each edge has one triangle on either side: the mesh is the surface of a solid, and nothing sees its backs.
bool is_closed(const Mesh& mesh);

}  // namespace gicube::samples

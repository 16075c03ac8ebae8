// A volumetric texture: a mesh covered by a thick layer of a volume. The layer consists of tetrahedra. In each, the
// texture coordinates are an affine map of space (shell maps: S. Porumbescu et al., SIGGRAPH 2005), so that rays stay
// straight in the volume.
#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "compose/ray_plan.h"
#include "gicube/scene/affine.h"
#include "gicube/shading.h"
#include "gicube/vector.h"
#include "meshes/mesh_caster.h"

namespace gicube::samples {

struct ShellSettings {
  double thickness = 0;            // along the corners' normals, in units of the mesh's space
  int repeat_u = 1, repeat_v = 1;  // copies of the volume over the mesh's texture coordinates 0..1
};

// The volume's x and y are along the texture coordinates u and v; its z points outwards from the mesh.
class Shell {
 public:
  // Throws InputError: a mesh without texture coordinates, more than 1000 copies of the volume on one of its triangles.
  Shell(const Mesh& mesh, const ShellSettings& settings, const Dims& dims);

  // Adds the spans of a ray, of unit direction, through the shell, one per tetrahedron and copy of the volume. They do
  // not overlap: if the shell does, as in a hollow that is narrower than it, the tetrahedron that the ray enters first
  // counts. Their shade is ambient + diffuse max(N.L, 0) with the mesh's smooth normals.
  void add_spans(Vec3 from, Vec3 direction, std::size_t volume, Vec3 towards_light, const Phong& phong,
                 std::vector<Span>& spans) const;
  const Mesh& faces() const { return caster_->meshes().front(); }

 private:
  // `weights` maps space to barycentric coordinates of corners 1 to 3; corner 0 has the rest of 1.
  struct Tetrahedron {
    Affine weights;
    std::array<Vec3, 4> places;   // in copies of the volume; heights 0..1
    std::array<Vec3, 4> normals;  // unit length

    // Barycentric coordinates at `from`, and their change per unit of distance.
    std::pair<std::array<double, 4>, std::array<double, 4>> weights_along(Vec3 from, Vec3 direction) const;
  };

  std::vector<Tetrahedron> tetrahedra_;
  std::unique_ptr<MeshCaster> caster_;  // their faces, four of each in turn
  Vec3 voxels_;                         // from a copy's first voxel to its last one
};

}  // namespace gicube::samples

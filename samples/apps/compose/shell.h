// A volumetric texture: a mesh that is covered by a thick layer of a volume. The layer is cut into tetrahedra, in each
// of which texture coordinates are an affine map of space (shell maps: S. Porumbescu et al., SIGGRAPH 2005), so that
// rays stay straight in the volume.
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
  double thickness = 0;            // along the corners' normals, units of the mesh's space
  int repeat_u = 1, repeat_v = 1;  // copies of the volume over the mesh's texture coordinates 0..1
};

// The volume's x and y lie along the texture coordinates u and v, its z from the mesh outwards.
class Shell {
 public:
  // Throws InputError: a mesh without texture coordinates, more than 1000 copies of the volume on one of its triangles.
  Shell(const Mesh& mesh, const ShellSettings& settings, const Dims& dims);

  // Adds the spans of a ray, of unit direction, through the shell: one for each tetrahedron and copy of the volume.
  // They do not overlap: where the shell does, as one that is thicker than a hollow, the tetrahedron that the ray
  // enters first counts. Their shade is that of the light, of the mesh's smooth normals: ambient + diffuse max(N.L, 0).
  void add_spans(Vec3 from, Vec3 direction, std::size_t volume, Vec3 towards_light, const Phong& phong,
                 std::vector<Span>& spans) const;
  const Mesh& faces() const { return caster_->meshes().front(); }

 private:
  // From space to barycentric coordinates of corners 1 to 3, which that of corner 0 makes up to 1.
  struct Tetrahedron {
    Affine weights;
    std::array<Vec3, 4> places;   // in copies of the volume, and 0..1 in height
    std::array<Vec3, 4> normals;  // unit length

    // Barycentric coordinates at `from`, and their change for a unit of the way.
    std::pair<std::array<double, 4>, std::array<double, 4>> weights_along(Vec3 from, Vec3 direction) const;
  };

  std::vector<Tetrahedron> tetrahedra_;
  std::unique_ptr<MeshCaster> caster_;  // their faces, four of each in turn
  Vec3 voxels_;                         // of a copy, between its first and last voxels' centres
};

}  // namespace gicube::samples

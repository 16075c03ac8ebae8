// The solids of a scene, each in its own coordinate system.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "gicube/export.h"
#include "gicube/scene/mesh.h"

namespace gicube::scene {

struct Distance {
  double distance = 0;
  Vec3 away;  // zero where no direction is nearest
};

// At a point of a solid's own space: zero on the surface, negative inside, `away` its gradient.
//   everywhere            a lower bound of the distance, by its absolute value (its gradient is at most 1 long), by
//                         which cells of voxels are skipped
//   to 1 voxel from the   the distance, or a value that approximates it after division by its gradient's length:
//   surface               densities follow it
//   to 3 voxels           the same for the tag between solids, and `away` as direction of the normals
// For hollow or cut solids, max(a, -b) of two fields has all these properties.
using Field = std::function<Distance(Vec3)>;

// Lengths in the units of the node that holds the shape.
struct SphereShape {  // around the origin
  double radius = 1;
  friend bool operator==(const SphereShape&, const SphereShape&) = default;
};

struct BoxShape {
  Vec3 low{-1, -1, -1}, high{1, 1, 1};
  double rounding = 0;  // of edges and corners, at most half of the shortest edge
  friend bool operator==(const BoxShape&, const BoxShape&) = default;
};

struct TorusShape {   // around the z axis
  double radius = 1;  // of the tube's centre line
  double tube = 0.25;
  friend bool operator==(const TorusShape&, const TorusShape&) = default;
};

struct CylinderShape {  // along the z axis, around the origin
  double radius = 1;
  double height = 2;
  double inner_radius = 0;  // above 0: a pipe
  double rounding = 0;      // of its edges
  friend bool operator==(const CylinderShape&, const CylinderShape&) = default;
};

struct MeshShape {             // closed surface
  std::filesystem::path file;  // .obj or .ply; unused if there is a mesh
  std::shared_ptr<const Mesh> mesh;
  friend bool operator==(const MeshShape&, const MeshShape&) = default;
};

struct FieldShape {  // any solid
  std::shared_ptr<const Field> field;
  friend bool operator==(const FieldShape&, const FieldShape&) = default;  // whether it is the same object
};

// "buckyball": atoms and bonds, the atoms' centres on the unit sphere. "buckyball_atoms", "buckyball_bonds": only
// these. "head": a stylised head that looks along -y, about 2 high.
struct BuiltinShape {
  std::string name;
  friend bool operator==(const BuiltinShape&, const BuiltinShape&) = default;
};

using Shape = std::variant<SphereShape, BoxShape, TorusShape, CylinderShape, MeshShape, FieldShape, BuiltinShape>;

// Throws InputError with the name of the shape's field ("radius: expected ..."). Does not open a mesh's file.
GICUBE_API void check(const Shape& shape);

// The fields whose union is the shape. Throws InputError like check() and for a mesh that is not closed, and FileError
// for a mesh's file.
GICUBE_API std::vector<Field> fields_of(const Shape& shape);

}  // namespace gicube::scene

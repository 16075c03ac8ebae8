// Sharp surfaces: where the trilinear field reaches a value. Between voxels the field is a cubic along a ray, so they
// are found to rounding, without steps; and their normal is the field's own gradient, so none faces into the solid.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "empty_space.h"
#include "path_scene.h"
#include "reference/field.h"

namespace gicube::reference::paths {

class Solids {
 public:
  struct Crossing {
    double distance = 0;
    int tag = 0;  // of the solid
    Vec3 normal;  // in voxels, towards lesser values, any length; zero at a border of tags
  };

  Solids(const PathScene& scene, const Field& field);

  bool any() const { return any_; }
  // The first distance from `begin` to `end` where a ray (in voxels) comes into a solid, or with `inside` leaves one.
  std::optional<Crossing> crossing(Vec3 origin, Vec3 direction, double begin, double end, bool inside) const;

 private:
  struct Cell {
    std::array<double, 3> low{};
    int tag = 0;
    std::array<double, 8> corners{};  // x fastest
  };
  Cell cell(Vec3 middle) const;
  Vec3 gradient(const Cell& cell, Vec3 voxel) const;
  EmptySpace empty_space() const;

  const Field& field_;
  std::array<std::optional<double>, 4> levels_;
  double reach_;
  std::array<std::size_t, 3> dims_{};
  std::vector<double> values_;
  bool any_ = false;
  EmptySpace empty_;  // of solids
};

}  // namespace gicube::reference::paths

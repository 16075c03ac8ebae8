// Energy spread trilinearly over voxels, in double precision [P §2.2].
#pragma once

#include <cstddef>
#include <vector>

#include "gicube/vector.h"

namespace gicube::reference {

class Splat {
 public:
  explicit Splat(Dims dims);

  // `position`: voxels, in the box [0, size - 1].
  void add(Vec3 position, double energy);
  double at(int x, int y, int z) const { return energy_[index(x, y, z)]; }
  double sum() const;

 private:
  std::size_t index(int x, int y, int z) const;

  Dims dims_;
  std::vector<double> energy_;
};

}  // namespace gicube::reference

#include "splat.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace gicube::reference {

Splat::Splat(Dims dims)
    : dims_(dims),
      energy_(static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) *
              static_cast<std::size_t>(dims[2])) {}

void Splat::add(Vec3 position, double energy) {
  const double place[3] = {position.x, position.y, position.z};
  int cell[3];
  double part[3];
  for (int axis = 0; axis < 3; ++axis) {
    const int last = dims_[static_cast<std::size_t>(axis)] - 1;
    if (!(place[axis] >= 0 && place[axis] <= last)) throw std::out_of_range("position outside the volume");
    cell[axis] = std::min(static_cast<int>(place[axis]), last - 1);
    part[axis] = place[axis] - cell[axis];
  }
  for (int corner = 0; corner < 8; ++corner) {
    double weight = energy;
    int at[3];
    for (int axis = 0; axis < 3; ++axis) {
      const int upper = corner >> axis & 1;
      at[axis] = cell[axis] + upper;
      weight *= upper != 0 ? part[axis] : 1 - part[axis];
    }
    energy_[index(at[0], at[1], at[2])] += weight;
  }
}

double Splat::sum() const { return std::accumulate(energy_.begin(), energy_.end(), 0.0); }

std::size_t Splat::index(int x, int y, int z) const {
  return (static_cast<std::size_t>(z) * static_cast<std::size_t>(dims_[1]) + static_cast<std::size_t>(y)) *
             static_cast<std::size_t>(dims_[0]) +
         static_cast<std::size_t>(x);
}

}  // namespace gicube::reference

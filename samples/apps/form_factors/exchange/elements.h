// The volume for form factors on the board: solids that are opaque up to their sides, and a medium.
//
// In a volume for pictures a solid's opacity rises over one or two voxels, and grazing rays pass there. Here a tag
// makes a voxel's whole box opaque, because a sample has the tag of its nearest voxel; density is only extinction.
// Solid voxels continue the density of the open voxels around them, so that interpolation adds no wall's density to
// open ones.
//
// Seven trees cover the elements of the solids and of the medium.
#pragma once

#include <cstdint>
#include <vector>

#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

using GridCell = std::array<int, 3>;  // a voxel's place

inline std::size_t voxel_index(const Dims& dims, const GridCell& cell) {
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  return at(cell[0]) + at(dims[0]) * (at(cell[1]) + at(dims[1]) * at(cell[2]));
}
// Calls visit(cell) for all voxels from `first` to before `end`, x fastest.
template <typename Visit>
void for_each_voxel(const GridCell& first, const GridCell& end, const Visit& visit) {
  GridCell cell{};
  for (cell[2] = first[2]; cell[2] < end[2]; ++cell[2]) {
    for (cell[1] = first[1]; cell[1] < end[1]; ++cell[1]) {
      for (cell[0] = first[0]; cell[0] < end[0]; ++cell[0]) visit(cell);
    }
  }
}

struct Medium {
  Dims dims{};
  Edges edges{1, 1, 1};
  std::vector<std::uint8_t> solid;  // 1 or 0 by voxel, x fastest
  std::vector<std::uint8_t> tags;   // of the materials, by voxel
  // Extinction per length, by voxel, as in the board's tables; continued into solids.
  std::vector<double> kappa;
  double max_kappa = 0;  // of density 4095
  std::vector<std::uint16_t> densities;

  std::size_t at(const GridCell& cell) const { return voxel_index(dims, cell); }
};

// Divides voxels into solid and open ones by the opacity of one voxel length. Throws InputError: no voxels,
// solid_opacity not within 0..1.
Medium make_medium(const SceneSetup& setup, double solid_opacity);

// Throws InputError if it is larger than the board's volumes, and what Board throws.
void load(Board& board, const Medium& medium);

// Exact mean of the interpolated extinction over the box of an open voxel.
double mean_kappa(const Medium& medium, const GridCell& voxel);

// Content of any box of the volume in constant time, from cumulative sums over the voxels.
class Contents {
 public:
  explicit Contents(const Medium& medium);

  struct Of {
    bool solid = false;       // any
    double mean_kappa = 0;    // of its voxels
    double kappa_spread = 0;  // their standard deviation
  };
  Of box(const std::array<double, 3>& low, const std::array<double, 3>& high) const;

 private:
  using Sums = std::array<double, 3>;  // of solid, kappa, kappa squared
  const Sums& before(const GridCell& cell) const { return sums_[voxel_index(ends_, cell)]; }

  Dims dims_, ends_;  // of the volume, and one more
  std::vector<Sums> sums_;
};

// Orders leaves by facing, then by the octree, so that the leaves of a cluster are adjacent.
std::vector<Leaf> make_leaves(const Medium& medium, const SceneSetup& setup, const Emissions& emissions);

struct Forest {
  std::vector<Leaf> leaves;
  std::vector<Cluster> clusters;
  std::vector<std::uint32_t> roots;  // at most seven
  std::vector<double> measures;      // leaves + 1 cumulative sums over the leaves of area, or kappa V
  Edges edges{1, 1, 1};

  // The factor of a mean over both elements: area, or kappa V.
  double exchange_measure(const Cluster& cluster) const { return measures[cluster.last] - measures[cluster.first]; }
};

// Does not divide cubes with edges of `leaf_voxels`, a power of two.
Forest make_forest(std::vector<Leaf> leaves, const Edges& edges, int leaf_voxels);

// The cluster's box as an element of the board; a full cluster fills it.
Element element_of(const Cluster& cluster);

// Whether the sides let any part of `a` see any part of `b`.
bool may_see(const Cluster& a, const Cluster& b);

}  // namespace gicube::samples

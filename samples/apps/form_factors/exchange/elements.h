// The volume that the board measures form factors in: solids that are opaque to their very sides, and a medium.
//
// In a volume made for pictures a solid's opacity rises over a voxel or two, which rays graze through. Here a tag,
// which a sample takes from its nearest voxel, makes the voxel's whole box opaque, and density is extinction alone.
// Within a solid it goes on as in the open voxels around, so that interpolation brings no wall's density into the open.
//
// Over its elements and those of the solids there are seven trees.
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
  // Extinction a length, by voxel, as the board's tables hold it; in solids continued.
  std::vector<double> kappa;
  double max_kappa = 0;  // of density 4095
  std::vector<std::uint16_t> densities;

  std::size_t at(const GridCell& cell) const { return voxel_index(dims, cell); }
};

// Takes voxels apart by the opacity of one voxel length. Throws InputError: no voxels, solid_opacity not within 0..1.
Medium make_medium(const SceneSetup& setup, double solid_opacity);

// Throws InputError if it is larger than the board's volumes, and what Board throws.
void load(Board& board, const Medium& medium);

// Mean extinction of the box of an open voxel: of the trilinear interpolation, exactly.
double mean_kappa(const Medium& medium, const GridCell& voxel);

// Content of any box of the volume in constant time: from running sums over all voxels before each.
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

// Leaves of one facing follow each other, in the order of the octree: those of a cluster lie together.
std::vector<Leaf> make_leaves(const Medium& medium, const SceneSetup& setup, const Emissions& emissions);

struct Forest {
  std::vector<Leaf> leaves;
  std::vector<Cluster> clusters;
  std::vector<std::uint32_t> roots;  // at most seven
  std::vector<double> measures;      // running sums over the leaves of area, or kappa V: leaves + 1 of them
  Edges edges{1, 1, 1};

  // The factor of a mean over both elements: area, or kappa V.
  double exchange_measure(const Cluster& cluster) const { return measures[cluster.last] - measures[cluster.first]; }
};

// Cubes of `leaf_voxels` an edge, a power of two, are not divided.
Forest make_forest(std::vector<Leaf> leaves, const Edges& edges, int leaf_voxels);

// Its box as the board takes it; of a full cluster all there is of it.
Element element_of(const Cluster& cluster);

// Whether any of `a` could see any of `b` by their sides alone.
bool may_see(const Cluster& a, const Cluster& b);

}  // namespace gicube::samples

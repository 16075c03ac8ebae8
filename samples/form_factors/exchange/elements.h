// The elements of a medium and its solids, and the seven trees over them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "form_factors/exchange/medium.h"
#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

// Leaves of one facing follow each other, in the order of the octree: those of a cluster lie together.
std::vector<Leaf> make_leaves(const Medium& medium, const SceneSetup& setup, const Emissions& emissions);

struct Forest {
  std::vector<Leaf> leaves;
  std::vector<Cluster> clusters;
  std::vector<std::uint32_t> roots;  // at most seven
  std::vector<double> measures;      // running sums over the leaves of area, or kappa V: leaves + 1 of them
  Edges edges{1, 1, 1};

  // What a mean over both elements is to be multiplied with: area, or kappa V.
  double exchange_measure(const Cluster& cluster) const { return measures[cluster.last] - measures[cluster.first]; }
};

// Cubes of `leaf_voxels` an edge, a power of two, are not divided.
Forest make_forest(std::vector<Leaf> leaves, const Edges& edges, int leaf_voxels);

// Its box as the board takes it; of a full cluster all there is of it.
Element element_of(const Cluster& cluster);

// Whether any of `a` could see any of `b` by their sides alone.
bool may_see(const Cluster& a, const Cluster& b);

}  // namespace gicube::samples

// Pairs of elements that are near relative to their size. f f / (pi r^2) varies so much between them that neither the
// mean of samples nor their scatter is reliable; where they touch it is unbounded. So they are divided into parts of
// about equal light. The geometric factor of each part is computed without rays, and rays determine the share of it
// that arrives.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "encode/geometric_factor.h"
#include "gicube/pair.h"

namespace gicube {

struct PairPart {
  std::uint32_t a = 0, b = 0;  // elements of its division
  double measure = 1;          // its share of all pairs of points
  GeometricFactor factor;
  bool near = false;  // is still near
};

struct Division {
  std::vector<Element> elements;  // voxels, relative to the first element's origin
  std::vector<PairPart> parts;
};

// Divisions and factors are cached: in a grid the same pairs recur, and their parts even more often.
class NearPairs {
 public:
  // The quantities that determine the factor of two boxes along the axes: for each axis the distance of their middles
  // and both lengths. Sorted, because mirrored or turned boxes have the same factor.
  using Placement = std::array<std::array<double, 3>, 3>;

  // `rays`: for each pair. The parts of a near pair share them.
  NearPairs(Vec3 spacing, std::uint32_t rays);

  std::uint32_t rays_per_part() const { return rays_per_part_; }

  // Null if the elements are not near, or one has no extent. Compares axis-parallel bounds, so some oblique pairs that
  // are a little further apart count as near.
  const Division* division_of(const Element& a, const Element& b);

  // Adds up the parts' factors, each found with rays_per_part() rays.
  PairFactor sum_up(const Division& division, std::span<const PairFactor> found) const;

 private:
  bool is_near(const Element& a, const Element& b) const;
  Division divide(const Element& a, const Element& b);
  GeometricFactor factor_of(const Element& a, const Element& b, bool near);  // with physical sides

  Vec3 spacing_;
  std::size_t parts_;
  std::uint32_t rays_per_part_;
  std::map<std::vector<double>, Division> known_;
  std::map<std::pair<Placement, bool>, GeometricFactor> factors_;
};

// The standard error of a far pair, with a term for features that no ray has hit: as if two of four further rays
// arrived (Agresti and Coull 1998). A clear pair keeps its error.
double error_with_unseen(const PairFactor& found, std::uint32_t rays);

}  // namespace gicube

// Pairs of elements that are near for their size. f f / (pi r^2) varies so much between them that neither the mean of
// some samples nor their scatter tells the truth; where they touch it has no bound. So they are divided into parts of
// about equal light: of each part the geometric factor is known without rays, and rays tell which share of it arrives.
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
  double measure = 1;          // of all pairs of points, the share that it has
  GeometricFactor factor;
  bool near = false;  // still
};

struct Division {
  std::vector<Element> elements;  // voxels, from the first element's origin
  std::vector<PairPart> parts;
};

// Keeps what it divided: in a grid the same pairs come again and again, and parts of them even more often.
class NearPairs {
 public:
  // The quantities that determine the factor of boxes along the axes: along each axis the distance of their middles,
  // and both lengths. Sorted, because mirrored or turned boxes have the same factor.
  using Placement = std::array<std::array<double, 3>, 3>;

  // For so many rays a pair, which the parts of a near pair share.
  NearPairs(Vec3 spacing, std::uint32_t rays);

  std::uint32_t rays_per_part() const { return rays_per_part_; }

  // Null if they are not near, or without extent. Bounds decide, so that oblique pairs that are a little further apart
  // are taken too.
  const Division* division_of(const Element& a, const Element& b);

  // `found`: of each part, by rays_per_part() rays.
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

// The standard error of a pair's rays, and with it what none of them has found but another two of four might (Agresti
// and Coull 1998). A clear pair has nothing to be found.
double error_with_unseen(const PairFactor& found, std::uint32_t rays);

}  // namespace gicube

// Parts of scans that pilots are made of.
#pragma once

#include <vector>

#include "cone_beam/plan/plan.h"

namespace gicube::samples {

// Which of the views may be left out so that the others are as evenly spread: each so many'th is kept, of a whole turn or, of less, from
// the first to the last. Ascending, from 2.
std::vector<int> strides_of(const ConeGeometry& geometry, int most);

// Some slices around the middle plane, and the detector's rows whose rays run through them.
struct Slab {
  ConeGeometry geometry;
  Projections projections;
};
Slab slab_of(const ConeGeometry& geometry, const Projections& projections, int slices);

}  // namespace gicube::samples

// Views of any list of angles, as a ConeGeometry wants them.
#pragma once

#include <cstddef>
#include <vector>

namespace gicube::samples {

struct SortedViews {
  std::vector<double> angles;                    // ascending within one turn
  std::vector<std::vector<std::size_t>> places;  // of each angle, in the list that came: several where it was repeated

  std::size_t repeated() const;  // places beyond the first of their angle
};

// Angles a whole number of turns apart are one [C: to 1e-6]. Where the angles leave a gap that is more than twice their second widest
// [C], as in a short scan, they begin behind it; else with the first of the list. `angles`: finite.
SortedViews sorted_views(const std::vector<double>& angles);

}  // namespace gicube::samples

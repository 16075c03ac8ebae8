// gicube-form-factors visibility: how much light goes between random voxels of a volume, and what it costs to find out.
#pragma once

#include <cstdint>
#include <vector>

#include "form_factors/program/options.h"
#include "form_factors/program/statistics.h"
#include "scene/program/progress.h"

namespace gicube::samples {

// Pairs of whole voxels (boxes from half a voxel below to half a voxel above their centres, cut off at the volume's ends) that
// are drawn from all alike, no voxel with itself. The same for a seed everywhere.
struct RandomPairs {
  std::vector<Element> elements;
  std::vector<ElementPair> pairs;
};
RandomPairs random_pairs(const Dims& dims, std::uint32_t count, std::uint64_t seed);

struct Visibility {
  std::uint64_t pairs = 0, clear_pairs = 0, rays = 0;  // rays: with those that clear pairs would have had
  std::vector<double> transmittances;                  // of each pair: the mean over its rays by their weight
  double transmittance = 0;                            // mean over the pairs
  double standard_error = 0;                           // of that, over pairs
  std::uint64_t hidden = 0;                            // pairs with less than 1e-3
  Picoseconds duration = 0;                            // simulated
  double host_seconds = 0;
  Counters counters;
  Utilisation utilisation;
};

// The volume is on the board. Throws what Board throws.
Visibility look(Board& board, const RandomPairs& pairs, const PairRequest& request, const Progress& progress = {});

// Prints, and writes --stats. Throws as solve().
void visibility(const VisibilityOptions& options, ProgressLine& progress);

}  // namespace gicube::samples

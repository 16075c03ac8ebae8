// What the hierarchy costs and what it saves: solutions of one scene by several thresholds, and by all pairs of leaves,
// against a full matrix with many more rays.
#pragma once

#include <string>
#include <vector>

#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

// Sum of w |H - reference| over the sum of w reference, over elements and channels; not of the volume's ends. Both must be of
// one scene with the same leaves: throws InputError.
double difference(const RadiosityResult& result, const RadiosityResult& reference);

struct StudyPoint {
  bool hierarchy = true;
  double error = 0;           // RadiositySettings::error
  double difference = 0;      // from the reference
  double standard_error = 0;  // of `difference`, as the results' own errors would have it
  RadiosityStatistics statistics;
};

// A point for each of `errors`, then one for the full matrix with `settings` if `full`. The reference has 4 times the rays, and
// another seed.
std::vector<StudyPoint> study_hierarchy(Board& board, const SceneSetup& setup, const Emissions& emissions,
                                        const RadiositySettings& settings, const std::vector<double>& errors,
                                        bool full = true, const RadiosityProgress& progress = {});

// hierarchy/ERROR, or hierarchy/full.
std::string name_of(const StudyPoint& point);

// With a line of names: hierarchy,error,difference,standard_error,links,all_pairs,rays,board_ms,bus_bytes,closure_rms,seconds,command.
// `command`: to which --point and a point's name are added.
std::string csv_of(const std::vector<StudyPoint>& points, const std::string& command = "gicube-form-factors charts");

}  // namespace gicube::samples

// The plan step of radiosity: chooses the links' threshold, their rays and the size of elements for a target.
//
// It solves one scene with thresholds that decrease by factors of the root of ten, each with new random numbers. The
// difference() of two successive solutions estimates the errors of both, and predicts that of the next. A full matrix
// is the last one, when the rays become as many. Before the third solution, it tries other numbers of rays and larger
// elements at the second threshold, and keeps the one with the fewest rays for its error. When solutions are good
// enough, it returns the one with the fewest rays.
#pragma once

#include <string>
#include <vector>

#include "form_factors/radiosity/radiosity.h"
#include "gicube/plan_text.h"

namespace gicube::samples {

struct RadiosityPlanPoint {
  bool hierarchy = true;
  double threshold = 0;  // RadiositySettings::error
  int rays = 0;          // RadiositySettings::rays
  int leaf_voxels = 1;
  std::uint32_t seed = 0;
  double difference = 0;              // from the solution before or after
  double error = 0, error_bound = 0;  // of the light on all elements, relative; see plan.cpp
  double all_rays = 0;                // of the solution
  Picoseconds time = 0;               // of the board
};

struct RadiosityPlan {
  RadiositySettings settings;  // as chosen
  RadiosityPlanPoint chosen;
  bool kept = true;                        // false: no solution reaches the target, and `result` is the nearest
  std::vector<RadiosityPlanPoint> points;  // all solutions, in their order
  double finest_rays = 0;                  // of a full matrix: the first estimates of all pairs of elements
  Picoseconds finest_time = 0;             // in proportion
  double all_rays = 0;                     // of all solutions
  double host_seconds = 0;
  PlanTarget target;
  RadiosityResult result;

  std::vector<std::string> explain() const;  // lines for the user
};

// `settings`: the fixed settings; its seed is the first solution's. Throws InputError (not exactly one target), and
// what solve_radiosity() throws.
RadiosityPlan plan_radiosity(Board& board, const SceneSetup& setup, const Emissions& emissions,
                             const RadiositySettings& settings, const PlanTarget& target,
                             const RadiosityProgress& progress = {});

// Sum of w |H - reference| over the sum of w reference, over elements and channels, without the volume's ends. Throws
// InputError unless both have the same leaves.
double difference(const RadiosityResult& result, const RadiosityResult& reference);

}  // namespace gicube::samples

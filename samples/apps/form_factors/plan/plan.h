// The plan step of radiosity: from a target to the threshold of the links, their rays and how far elements are divided.
//
// Solutions of one scene are made with thresholds that fall by the root of ten, each with other random choices. What
// one differs from the next (difference()) is what both err; so each tells how good both were, and how much better the
// next will be. Where rays become as many as a full matrix would take, that is the last one. Before the third, other
// numbers of rays and larger elements are tried at the second threshold, and the one that needs the fewest rays for its
// error is kept. Once any is good enough, the one of those with the fewest rays is the solution.
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
  double difference = 0;              // from the solution that it is held against: the one before or the next
  double error = 0, error_bound = 0;  // of the light on all elements, relative; see plan.cpp
  double all_rays = 0;                // that it took
  Picoseconds time = 0;               // of the board
};

struct RadiosityPlan {
  RadiositySettings settings;  // as chosen
  RadiosityPlanPoint chosen;
  bool kept = true;                        // false: nothing reaches the target, and `result` is what comes nearest
  std::vector<RadiosityPlanPoint> points;  // every solution, in that order
  double finest_rays = 0;                  // of a full matrix: the rays of a first guess for every pair of elements
  Picoseconds finest_time = 0;             // in proportion
  double all_rays = 0;                     // of all solutions
  double host_seconds = 0;
  PlanTarget target;
  RadiosityResult result;

  std::vector<std::string> explain() const;  // lines for people
};

// `settings`: what is not chosen; its seed is the first solution's. Throws InputError (one of both targets), and as
// solve_radiosity().
RadiosityPlan plan_radiosity(Board& board, const SceneSetup& setup, const Emissions& emissions,
                             const RadiositySettings& settings, const PlanTarget& target,
                             const RadiosityProgress& progress = {});

// Sum of w |H - reference| over the sum of w reference, over elements and channels; not of the volume's ends. Both must
// be of one scene with the same leaves: throws InputError.
double difference(const RadiosityResult& result, const RadiosityResult& reference);

}  // namespace gicube::samples

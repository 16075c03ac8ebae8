// A plan held against the pictures that it is about.
#pragma once

#include <string>
#include <vector>

#include "gicube/plan.h"
#include "scenes.h"

namespace gicube::plan_study {

struct Target {
  double max_error = 0;
  Picoseconds time_budget = 0;
};

struct Cost {
  double samples = 0;
  Picoseconds time = 0;
  double host_seconds = 0;
};

struct PlanOutcome {
  Plan plan;
  double error = 0;  // of the plan's whole picture against the best setting's
  Cost chosen, best, finest;
  // The same against the double-precision march at a sixteenth of a voxel, if asked for.
  double exact_error = 0, exact_error_of_best = 0, exact_error_of_finest = 0;
};

// Relative root mean square difference of red, green, blue and alpha (gicube/plan.h).
double relative_error(const Image& image, const Image& best);

// `uri` with room for the scene.
std::string uri_for(const StudyScene& study, const std::string& uri);

// The plans of the scene's picture of `size` x `size` pixels for these errors, on one board. Not of lit scenes.
std::vector<Plan> plans_for(const StudyScene& study, int size, const std::vector<double>& max_errors,
                            const std::string& uri);

// How many of the settings that a plan for an error tried are cheaper than the chosen one, and their bounds keep the
// target.
int cheaper_and_kept(const Plan& plan);

// Plans the scene's picture of `size` x `size` pixels on a board of its own, renders it by the plan, by the best and by
// the finest setting with the whole volume, and exactly, if asked for (not of lit scenes).
PlanOutcome carry_out(const StudyScene& study, int size, const Target& target, const std::string& uri,
                      bool exact = false);

// Relative errors of pictures of `size` x `size` pixels by these steps, rays to their end, the whole volume, each
// against the double-precision march at a sixteenth of a voxel. Not of lit scenes.
std::vector<double> errors_of_steps(const StudyScene& study, int size, const std::string& uri,
                                    const std::vector<double>& steps);

}  // namespace gicube::plan_study

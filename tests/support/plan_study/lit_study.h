// Plans of light held against light of many more rays.
#pragma once

#include <string>

#include "gicube/light_plan.h"
#include "gicube/plan.h"
#include "study.h"

namespace gicube::plan_study {

struct LitOutcome {
  LightPlan light;
  Plan picture;
  double light_error = 0;      // of the best setting's picture, by the plan's light
  double error = 0;            // of the plan's picture by the plan's light
  double bound = 0;            // of that, as light and picture together predict it
  double reference_noise = 0;  // what is left in the light that both are held against
  double asked_samples = 0;    // of a pass as the scene asks for
};

// Plans light and picture of the scene, on a board of its own, as gicube-render does, and holds them against the mean
// of eight pictures by lights of 256 rays a face voxel with other seeds, low albedo, half a voxel.
LitOutcome carry_out_lit(const LitScene& scene, int size, const std::string& uri);

}  // namespace gicube::plan_study

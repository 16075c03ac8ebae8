// Plans of radiosity held against full matrices.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "form_factors/plan/plan.h"
#include "study.h"

namespace gicube::plan_study {

// One was there while plan_radiosity() was written (batch 0); the others were named in this file before it was run on
// them.
struct RadiosityScene {
  std::string name;
  samples::Scene scene;
  double max_error = 0;
  int batch = 0;
};
std::vector<RadiosityScene> radiosity_scenes(const std::filesystem::path& sources);

struct RadiosityOutcome {
  samples::RadiosityPlan plan;
  double error = 0;            // of the plan's solution against the full matrix
  double reference_error = 0;  // what two full matrices differ by
  double reference_rays = 0;
  double host_seconds = 0;  // of one of them
};

// Plans the scene's light on a board of its own, and holds it against a full matrix with four times the rays.
RadiosityOutcome carry_out_radiosity(const RadiosityScene& scene, const std::string& uri);

}  // namespace gicube::plan_study

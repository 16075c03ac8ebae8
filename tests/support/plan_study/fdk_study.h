// Plans of filtered backprojection held against the finest setting, in the whole volume.
#pragma once

#include <string>
#include <vector>

#include "cone_beam/phantom/phantom.h"
#include "cone_beam/plan/plan.h"

namespace gicube::plan_study {

// One was there while plan_fdk() was written (batch 0); the others were named in this file before it was run on them.
struct FdkScan {
  std::string name;
  samples::Phantom phantom;
  samples::ConeGeometry geometry;
  double photons = 0;  // a pixel; 0: no noise
  double max_error = 0;
  int batch = 0;
};
std::vector<FdkScan> fdk_scans();

struct FdkOutcome {
  samples::FdkPlan plan;
  double error = 0;                    // of the plan's volume against the finest setting's, in the same field of view
  double truth = 0, finest_truth = 0;  // of both against the phantom
  double deposits = 0, finest_deposits = 0;
  double host_seconds = 0, finest_seconds = 0;
};

FdkOutcome carry_out_fdk(const FdkScan& scan, const std::string& uri);

}  // namespace gicube::plan_study

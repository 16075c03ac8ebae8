// What a command cost and came to, as the JSON files of --stats.
#pragma once

#include <nlohmann/json.hpp>

#include "cone_beam/plan/plan.h"
#include "cone_beam/program/options.h"
#include "cone_beam/reconstruction.h"
#include "cone_beam/scan/scan.h"

namespace gicube::samples {

// Keys: scan (views views_read repeated detector source_to_axis source_to_detector arc_degrees absorbed dead), volume (dims spacing
// centre), method and its settings, rays, deposits, overflowed, clipped, iterations, residuals, diverged, warnings, plan (the
// program adds it; null without one), and those of `cost` (cost_json()).
nlohmann::ordered_json to_json(const ReconstructOptions& options, const Scan& scan, const Reconstruction& result,
                               const nlohmann::ordered_json& cost);

// Keys: max_error time_budget_ms kept chosen finest (points) slices pilots pilot_deposits host_seconds points, each with every rays step
// normalise error error_bound deposits board_ms.
nlohmann::ordered_json to_json(const FdkPlan& plan);

// Keys: voxels rmse bias relative_l2 psnr ssim; an infinite psnr is null.
nlohmann::ordered_json to_json(const Comparison& comparison);

}  // namespace gicube::samples

// What a command cost and came to, as the JSON files of --stats.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "cone_beam/plan/plan.h"
#include "cone_beam/program/options.h"
#include "cone_beam/reconstruction.h"
#include "cone_beam/scan/scan.h"
#include "gicube/board.h"

namespace gicube::samples {

// Of a part of a board's work.
struct Cost {
  BoardInfo board;
  Counters counters;
  Picoseconds simulated = 0;
  double host_seconds = 0;  // wall clock
};

// Keys: board_ms bus_ms bus_down_bytes bus_up_bytes host_seconds board counters.
nlohmann::ordered_json to_json(const Cost& cost);

// Keys: scan (views views_read repeated detector source_to_axis source_to_detector arc_degrees absorbed dead), volume (dims spacing
// centre), method and its settings, rays, deposits, overflowed, clipped, iterations, residuals, diverged, warnings, plan (the
// program adds it; null without one), and the cost's.
nlohmann::ordered_json to_json(const ReconstructOptions& options, const Scan& scan, const Reconstruction& result,
                               const Cost& cost);

// Keys: max_error time_budget_ms kept chosen finest (points) slices pilots pilot_deposits host_seconds points, each with every rays step
// normalise error error_bound deposits board_ms.
nlohmann::ordered_json to_json(const FdkPlan& plan);

// Keys: voxels rmse bias relative_l2 psnr ssim; an infinite psnr is null.
nlohmann::ordered_json to_json(const Comparison& comparison);

const char* name_of(const ReconstructOptions& options);  // of the method, as on the command line

}  // namespace gicube::samples

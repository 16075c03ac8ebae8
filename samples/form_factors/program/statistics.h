// What a solution or a look between voxels cost and came to, as the JSON files of --stats.
#pragma once

#include <nlohmann/json.hpp>

#include "form_factors/plan/plan.h"
#include "form_factors/program/options.h"
#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

// What the board did in a time, as shares of it. A part that the fidelity level does not model has none.
struct Utilisation {
  double bus_down = 0, bus_up = 0;  // of one bus, on which both directions take turns
  double dsp = 0;
  std::optional<double> pipelines;  // cycles of the busiest processor that took a sample
  std::optional<double> sorter;     // its cycles that were lost because its sorter had no ray ready
  std::optional<double> memory;     // data cycles of the busiest RDRAM channel

  // The name of the busiest part.
  std::string bound() const;
};
Utilisation utilisation_of(const Counters& counters, Picoseconds duration, const BoardInfo& board);

nlohmann::ordered_json to_json(const Utilisation& utilisation);

const char* name_of(PairRays made);  // as on the command line

// Keys: elements clusters links all_pairs pairs rays refinements iterations (links, residual) energy (powers of red, green
// and blue, in the scene's units; balance_error) closure_rms standard_error (of the incident light: mean, greatest, relative)
// bus_down_bytes bus_up_bytes board_ms bus_ms host_seconds utilisation settings board counters. The program adds plan,
// null without one.
nlohmann::ordered_json to_json(const RadiosityResult& result, const RadiositySettings& settings, double area_unit,
                               const Counters& counters, const BoardInfo& board);

// Keys: max_error time_budget_ms kept chosen (a point) full_matrix_rays all_rays host_seconds points, each with hierarchy threshold rays_a_link
// leaf_voxels difference error error_bound rays board_ms.
nlohmann::ordered_json to_json(const RadiosityPlan& plan);

// (emitted - all that it became) / emitted, the worst channel.
double balance_error(const EnergyBalance& energy);

}  // namespace gicube::samples

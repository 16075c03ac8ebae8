// The plan step of a picture (gicube/plan.h), as gicube-render asks for it.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include "common/board_options.h"
#include "common/plan_options.h"
#include "common/scene.h"
#include "gicube/plan.h"

namespace gicube::samples {

// A time budget needs a board that keeps time: `approximate`, unless a fidelity level is asked for.
BoardOptions board_for(const PlanOptions& plan, BoardOptions board);

// Plans the setup's picture and brings its volume onto the board as planned, codebook included. An emulated board of level
// `cycle` has its pilots taken by one of level `approximate`, which has the same bits sooner. Throws the driver's errors.
Plan plan_and_load(Board& board, const BoardOptions& options, const PlanOptions& wanted, const SceneSetup& setup,
                   bool own_codebook, const Progress& progress);

// Loads only the part of the setup's volume in which anything shows, whose voxels are freed on the way. Returns where it lies.
Placement load_visible_part(Board& board, SceneSetup& setup, bool own_codebook, const Progress& progress);

// Plans a picture of what the board holds, light included.
Plan plan_lit(Board& board, const PlanOptions& wanted, const View& view, const Progress& progress);

nlohmann::ordered_json to_json(const Plan& plan);

}  // namespace gicube::samples

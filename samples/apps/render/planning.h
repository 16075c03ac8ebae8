// The plan step of a picture (gicube/plan.h), as gicube-render asks for it.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include "gicube/light_plan.h"
#include "gicube/plan.h"
#include "gicube/scene/scene.h"
#include "render/colour_passes.h"
#include "scene/program/board_options.h"
#include "scene/program/plan_options.h"

namespace gicube::samples {

// Plans the setup's picture and brings its volume onto the board as planned, codebook included. Throws the driver's
// errors.
Plan plan_and_load(Board& board, const PlanOptions& wanted, const SceneSetup& setup, bool own_codebook,
                   const Progress& progress);

// Loads what stands for the setup's volume, whose voxels are freed on the way: the part in which anything shows
// (`crop`), voxels of 2^level (gicube/level_of_detail.h), or both. Returns where it lies.
Placement load_derived(Board& board, SceneSetup& setup, bool crop, int level, bool own_codebook,
                       const Progress& progress);

// Plans one pass's light for the picture that it is to light, of `passes` together, with what light may take of the
// target: half of the error's square, half of the time. The board holds that light then.
LightPlan plan_pass(Board& board, const PlanOptions& wanted, const SceneSetup& setup, const LightPass& pass,
                    std::size_t passes, const Progress& progress);

// Plans a picture of what the board holds, light included, with what its light left of the target: `light` of the first
// of `passes`, or nothing, for a picture that is only scattered.
Plan plan_lit(Board& board, const PlanOptions& wanted, const View& view, const std::vector<LightPlan>& light,
              std::size_t passes, const Progress& progress);

// Lines for people: of the light, of the picture, and of both.
std::vector<std::string> explain(const PlanOptions& wanted, const Plan& picture, const std::vector<LightPlan>& light);

nlohmann::ordered_json to_json(const Plan& plan);
nlohmann::ordered_json to_json(const LightPlan& plan);

}  // namespace gicube::samples

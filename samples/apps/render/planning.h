// Planning of a picture (gicube/plan.h) for gicube-render.
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

// Plans the setup's picture and loads its volume as planned, including the codebook. Throws the driver's errors.
Plan plan_and_load(Board& board, const PlanOptions& wanted, const SceneSetup& setup, bool own_codebook,
                   const Progress& progress);

// Loads a volume derived from the setup's, whose voxels are freed: the part with visible voxels (`crop`), voxels of
// 2^level (gicube/level_of_detail.h), or both. Returns its placement.
Placement load_derived(Board& board, SceneSetup& setup, bool crop, int level, bool own_codebook,
                       const Progress& progress);

// Plans the light of one of `passes`, with light's part of the target: half of the squared error, half of the time. The
// board has that light afterwards.
LightPlan plan_pass(Board& board, const PlanOptions& wanted, const SceneSetup& setup, const LightPass& pass,
                    std::size_t passes, const Progress& progress);

// Plans a picture of the board's volume and light, with the part of the target that the light has left. `light`: the
// plan of the first of `passes`; empty for a picture with scattering but without lighting.
Plan plan_lit(Board& board, const PlanOptions& wanted, const View& view, const std::vector<LightPlan>& light,
              std::size_t passes, const Progress& progress);

// Lines of text on the light, the picture, and both together.
std::vector<std::string> explain(const PlanOptions& wanted, const Plan& picture, const std::vector<LightPlan>& light);

nlohmann::ordered_json to_json(const Plan& plan);
nlohmann::ordered_json to_json(const LightPlan& plan);

}  // namespace gicube::samples

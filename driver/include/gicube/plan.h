// The plan step: from a scene and a target to the cheapest settings that reach it, found by pilot pictures.
//
//   gicube::Plan plan = gicube::make_plan(board, {.volume = view, .looks = looks, .view = camera, .max_error = 0.01});
//   gicube::Image image = board.render(plan.view(camera));       // the board holds the plan's volume
//
// A pilot is the picture with few pixels, which are a systematic sample of it: each of its rays is one that the picture
// has too. Pilots are compared with that of the most accurate setting: the whole volume, rays to their end, steps of a
// quarter of a voxel, or of a sixteenth with the wide datapath (BoardInfo::wide).
// "Error" is the root of the mean square difference of red, green, blue and alpha over all pixels, divided by the root
// mean square of the best picture, so that background does not count. It is what settings do to a picture; how far the
// board's best one is from an exact one is in docs/studies/accuracy.md. "Cost" is compared with the finest setting, a
// sixteenth of a voxel. On the paper's datapath its picture is worse than the best one, since positions drift with the
// number of steps.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/level_of_detail.h"

namespace gicube {

struct PlanRequest {  // a scene and a target
  // The volume to be drawn. Without samples: the board's volume, at its own level of detail, tables and shading.
  VolumeView volume{};
  std::span<const TransferFunction> looks{};  // by tag, in the volume's values; with `volume` only
  View view{};                                // its step and opacity_threshold don't count
  // One of both, or neither for the most accurate setting.
  double max_error = 0;  // relative, as above; > 0: the cheapest setting whose error_bound is no larger
  // > 0: of one picture; the most accurate setting that keeps it. The plan makes the whole picture to find out.
  Picoseconds time_budget = 0;
  // An edge of a square pilot, 16..512. Settings that are within the target by their estimate, not by their bound, get
  // a larger one, of twice that or a third of the picture's edge, where the picture has room for it.
  int pilot_pixels = 48;
};

// One setting, and what its pilot showed.
struct PlanPoint {
  int level = 0;
  double step = 0;  // voxels of that level
  double opacity_threshold = 0;
  double error = 0;        // as found in the pilot
  double error_bound = 0;  // see Plan
  double samples = 0;      // predicted, of the whole picture
  // Predicted for it; that of Plan::chosen was simulated. 0 where the board's fidelity level keeps no time in its
  // pipelines.
  Picoseconds time = 0;
  int pilot_width = 0;
  int pilot_height = 0;
};

struct GICUBE_API Plan {
  // The error is not known before the picture is made. The bound is 5/4 of the root of: the pilot's mean square error,
  // four of its standard errors, and three times what the worst pixel adds to it (what none of n pixels shows is in
  // fewer than 3/n of all, at 95% confidence). chosen: checked with scenes that it was not made with
  // (docs/guide/plan.md).
  PlanPoint chosen;
  PlanPoint best;                 // what errors are compared with: level 0, the best step, rays to their end
  PlanPoint finest;               // what costs are compared with: level 0, a sixteenth of a voxel, rays to their end
  bool kept = true;               // false: nothing reaches the target, and `chosen` is what comes nearest
  std::vector<PlanPoint> points;  // every setting tried, in that order

  Placement placement;    // of the volume that the board holds now
  Dims dims{};            // its size; 0 if the request had no volume
  Dims original_dims{};   // of the request's
  VoxelBox box{};         // the part of the original that is left; all of it, unless much of it is invisible
  bool gradients = true;  // false: the picture is not shaded, and none were made
  double voxels_a_pixel = 0;
  int level_for_pixels = 0;                   // level_for() of that
  std::vector<LevelError> level_errors;       // of level 1 and up, as far as they were tried
  Fidelity fidelity = Fidelity::kFunctional;  // the cheapest level of emulation that answers what was asked
  std::uint32_t pilots = 0;
  double pilot_samples = 0;  // of all pilots together
  double pilot_host_seconds = 0;

  // The caller's view, with the plan's settings, for the volume on the board.
  View view(const View& original) const;
  // The choice, its reasons, and its savings; lines for people.
  std::vector<std::string> explain() const;

  PlanRequest request;  // volume and looks removed: what they point to may be gone
};

// A volume is loaded for each level that is tried, and the board holds the plan's volume and looks afterwards; its
// shading (set_shading()) is used as it is. Pictures that are lit by irradiance, or scattered, are planned with what
// the board holds. Boards of all fidelity levels make the same plan except for times, which `functional` does not keep.
// Throws BadArgument (request), Rejected (no volume), and as load_volume() and render() do.
GICUBE_API Plan make_plan(Board& board, const PlanRequest& request, const Progress& progress = {});

// Gives another board the state in which make_plan() left its own, with the request's volume and transfer functions.
GICUBE_API void load_planned(Board& board, const Plan& plan, const VolumeView& volume,
                             std::span<const TransferFunction> looks);

}  // namespace gicube

// The plan step of light: from a scene and a target to albedo, number and step of the lighting rays. It is found by
// passes of few rays and pilots of the picture that they light (plan.h plans the picture itself).
//
//   gicube::LightPlan light = gicube::plan_light(board, {.lights = lights, .settings = illumination, .view = camera,
//                                                        .max_error = gicube::share_of_light(0.05)});
//   board.illuminate(lights, light.settings(illumination));     // what the board holds already
//
// A pass of few rays is noisy. Two passes of one setting with different seeds measure it: the noise is half of the mean
// square difference of their pictures. It falls with the number of rays, so a few predict how many are needed; two
// passes of so many decide. The effect of another albedo or step, free of noise, is the mean product of the differences
// of two independent pairs of passes. "Error" is as in plan.h: of the picture, and of what light does to it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/plan_text.h"

namespace gicube {

struct LightPlanRequest {  // lights and a target
  std::span<const Light> lights;
  // Rules, jitter, leaps, lifetime and seed stay; with the printed rules the albedo too, since there the two albedos
  // differ. The plan's cost is compared with all of these settings.
  Illumination settings{};
  View view{};       // of the picture; its step, threshold and size don't count
  int channel = -1;  // 0, 1, 2: only red, green or blue of it is taken (one of three passes)
  // One of both.
  double max_error = 0;         // relative, 0..1
  Picoseconds time_budget = 0;  // of the pass
  int max_rays = 256;           // per face voxel, 1..4096: no more are chosen, however small the error
  int pilot_pixels = 64;        // along each edge of a pilot, 16..512
};

// One setting, and what two passes of it showed, or what other passes predict.
struct LightPoint {
  Albedo albedo = Albedo::kLow;
  double step = 0;
  int rays_per_face_voxel = 0;
  double error = 0, error_bound = 0;  // both of the following together
  double noise = 0, bias = 0;
  double rays = 0, samples = 0;  // of a pass
  Picoseconds time = 0;          // 0 where the board's fidelity level keeps no time in its pipelines
};

struct GICUBE_API LightPlan {
  LightPoint chosen;
  LightPoint asked;                // the request's own settings, predicted from passes of fewer rays
  bool kept = true;                // false: nothing reaches the target, and `chosen` is what comes nearest
  bool at_limit = false;           // more rays were found to bring nothing: the energy words' rounding is left
  std::vector<LightPoint> points;  // every setting that passes were made of, in that order
  std::uint32_t passes = 0;
  double pass_samples = 0;  // of all passes together
  double host_seconds = 0;

  Illumination settings(const Illumination& original) const;
  std::vector<std::string> explain() const;  // lines for people

  PlanTarget target;
  int channel = -1;
};

// The part of an error that light gets [C: half of its square], and what a plan of light leaves of it to the picture.
GICUBE_API double share_of_light(double max_error);
GICUBE_API double left_for_picture(double max_error, const LightPlan& light);

// The board needs volume, looks and materials, and holds the light of the chosen settings afterwards.
// Throws BadArgument (request), and as illuminate() and render() do.
GICUBE_API LightPlan plan_light(Board& board, const LightPlanRequest& request, const Progress& progress = {});

}  // namespace gicube

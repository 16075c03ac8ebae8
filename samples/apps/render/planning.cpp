#include "render/planning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "scene/program/board_run.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

std::vector<TransferFunction> looks_of(const SceneSetup& setup) {
  const ValueRange range = value_range_of(setup.volume);
  std::vector<TransferFunction> looks;
  for (const TransferFunctionFile& material : setup.materials) looks.push_back(in_values_of(range, material));
  return looks;
}

PlanRequest request_of(const PlanOptions& wanted, const View& view) {
  PlanRequest request;
  request.view = view;
  request.max_error = wanted.max_error;
  request.time_budget = wanted.time_budget;
  return request;
}

Json ms_or_null(Picoseconds time) { return time > 0 ? Json(to_ms(time)) : Json(nullptr); }

Json point_json(const PlanPoint& point) {
  return {{"level", point.level},
          {"step", point.step},
          {"opacity_threshold", point.opacity_threshold},
          {"error", point.error},
          {"error_bound", point.error_bound},
          {"samples", point.samples},
          {"frame_ms", ms_or_null(point.time)},
          {"pilot", {{"width", point.pilot_width}, {"height", point.pilot_height}}}};
}

Json point_json(const LightPoint& point) {
  return {{"albedo", point.albedo == Albedo::kHigh ? "high" : "low"},
          {"rays_per_face_voxel", point.rays_per_face_voxel},
          {"step", point.step},
          {"error", point.error},
          {"error_bound", point.error_bound},
          {"noise", point.noise},
          {"bias", point.bias},
          {"rays", point.rays},
          {"samples", point.samples},
          {"pass_ms", ms_or_null(point.time)}};
}

}  // namespace

Plan plan_and_load(Board& board, const PlanOptions& wanted, const SceneSetup& setup, bool own_codebook,
                   const Progress& progress) {
  const std::vector<TransferFunction> looks = looks_of(setup);
  PlanRequest request = request_of(wanted, setup.view);
  request.volume = setup.volume_view();
  request.looks = looks;
  if (own_codebook) set_own_codebook(board, setup);
  return make_plan(board, request, progress);
}

Placement load_derived(Board& board, SceneSetup& setup, bool crop, int level, bool own_codebook,
                       const Progress& progress) {
  const std::vector<TransferFunction> looks = looks_of(setup);
  if (own_codebook) set_own_codebook(board, setup);
  const VolumeView whole = setup.volume_view();
  DerivedVolume derived;
  if (crop) {
    derived = cropped(whole, visible_box(whole, looks));
    setup.free_voxels();
  }
  if (level > 0) {
    DerivedVolume coarse = coarser(crop ? derived.view() : whole, level);
    const Placement outer = derived.placement, inner = coarse.placement;
    coarse.placement = {outer.low + outer.edge * inner.low, outer.edge * inner.edge};
    derived = std::move(coarse);
    setup.free_voxels();
  }
  VolumeView view = derived.view();
  view.find_gradients = setup.view.shade;
  if (!setup.view.shade) view.gradients = {};
  board.load_volume(view, progress);
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < looks.size(); ++tag) {
    board.set_transfer_function(derived.placement.look(looks[tag], range), static_cast<int>(tag));
  }
  return derived.placement;
}

LightPlan plan_pass(Board& board, const PlanOptions& wanted, const SceneSetup& setup, const LightPass& pass,
                    std::size_t passes, const Progress& progress) {
  LightPlanRequest request;
  request.lights = pass.lights;
  request.settings = setup.lighting.settings;
  request.settings.light_colours = pass.light_colours;
  request.view = setup.view;
  request.view.exposure = setup.lighting.exposure;
  request.channel = pass.channel;
  if (wanted.max_error > 0) request.max_error = share_of_light(wanted.max_error);
  request.time_budget = wanted.time_budget / (2 * passes);
  request.max_rays = std::max(request.max_rays, request.settings.rays_per_face_voxel);
  return plan_light(board, request, progress);
}

Plan plan_lit(Board& board, const PlanOptions& wanted, const View& view, const std::vector<LightPlan>& light,
              std::size_t passes, const Progress& progress) {
  PlanRequest request = request_of(wanted, view);
  if (!light.empty()) {
    // With several passes, the light of the others is not planned yet, but stays within its half.
    if (wanted.max_error > 0) {
      request.max_error =
          passes > 1 ? share_of_light(wanted.max_error) : left_for_picture(wanted.max_error, light.front());
    }
    const Picoseconds budget = wanted.time_budget / passes, taken = passes > 1 ? budget / 2 : light.front().chosen.time;
    if (budget > 0) request.time_budget = budget > taken ? budget - taken : 1;
  }
  return make_plan(board, request, progress);
}

std::vector<std::string> explain(const PlanOptions& wanted, const Plan& picture, const std::vector<LightPlan>& light) {
  const std::vector<std::string> lines = picture.explain();
  if (light.empty()) return lines;
  // Each of three passes has its own channel of the picture: the worst one bounds the error.
  double error = 0;
  bool kept = picture.kept;
  for (const LightPlan& plan : light) {
    error = std::max(error, plan.chosen.error_bound);
    kept = kept && plan.kept;
  }
  error = std::hypot(error, picture.chosen.error_bound);
  if (wanted.max_error > 0) kept = error <= wanted.max_error;
  std::vector<std::string> all{plan_headline("of light and picture", wanted.target(), kept),
                               fmt::format("error of both together: bound {:.2g}%", 100 * error)};
  for (const LightPlan& plan : light) std::ranges::copy(plan.explain(), std::back_inserter(all));
  all.insert(all.end(), lines.begin(), lines.end());
  return all;
}

Json to_json(const Plan& plan) {
  Json json = target_json({plan.request.max_error, plan.request.time_budget}, plan.kept);
  json["chosen"] = point_json(plan.chosen);
  json["finest"] = point_json(plan.finest);
  json["gradients"] = plan.gradients;
  json["box"] = {{"low", plan.box.low}, {"size", plan.box.size}};
  json["pilots"] = {
      {"pictures", plan.pilots}, {"samples", plan.pilot_samples}, {"host_seconds", plan.pilot_host_seconds}};
  for (const PlanPoint& point : plan.points) json["points"].push_back(point_json(point));
  return json;
}

Json to_json(const LightPlan& plan) {
  Json json = target_json(plan.target, plan.kept);
  json["channel"] = plan.channel;
  json["chosen"] = point_json(plan.chosen);
  json["asked"] = point_json(plan.asked);
  json["passes"] = {{"count", plan.passes}, {"samples", plan.pass_samples}, {"host_seconds", plan.host_seconds}};
  for (const LightPoint& point : plan.points) json["points"].push_back(point_json(point));
  return json;
}

}  // namespace gicube::samples

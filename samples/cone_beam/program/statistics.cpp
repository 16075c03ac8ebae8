#include <algorithm>
#include <numbers>

#include "cone_beam/program/options.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(Vec3 v) { return {v.x, v.y, v.z}; }

template <typename Value>
std::string name_of(const std::map<std::string, Value>& names, Value value) {
  return std::ranges::find(names, value, &std::pair<const std::string, Value>::second)->first;
}

Json scan_json(const Scan& scan) {
  const auto& [to_axis, to_detector, detector, volume, angles] = scan.geometry;
  const Json pixels{{"columns", detector.columns}, {"rows", detector.rows},         {"pitch_u", detector.pitch_u},
                    {"pitch_v", detector.pitch_v}, {"offset_u", detector.offset_u}, {"offset_v", detector.offset_v}};
  return {{"views", angles.size()},      {"views_read", scan.views_read},
          {"repeated", scan.repeated},   {"arc_degrees", (angles.back() - angles.front()) * 180 / std::numbers::pi},
          {"source_to_axis", to_axis},   {"source_to_detector", to_detector},
          {"detector", pixels},          {"absorbed", scan.flat_field.absorbed},
          {"dead", scan.flat_field.dead}};
}

Json fdk_json(const FdkSettings& fdk) {
  Json json{{"window", name_of(kWindows, fdk.window)},
            {"rays", fdk.rays},
            {"step", fdk.step},
            {"sharpen", fdk.sharpen},
            {"normalise", fdk.normalise},
            {"accumulator", name_of(kAccumulators, fdk.accumulator)}};
  if (fdk.accumulator == Accumulator::kIrradiance) {
    json.update(Json{{"read_every", fdk.read_every}, {"bits", fdk.bits}, {"headroom", fdk.headroom}});
  }
  return json;
}

Json algebraic_json(const AlgebraicSettings& settings) {
  Json json{{"iterations", settings.iterations}};
  if (settings.method == Method::kOsSart) json["subsets"] = settings.subsets;
  json.update(Json{{"relaxation", settings.relaxation},
                   {"order", name_of(kViewOrders, settings.order)},
                   {"non_negative", settings.non_negative},
                   {"stop", settings.stop},
                   {"noise_level", settings.noise},
                   {"step", settings.step},
                   {"seed", settings.seed}});
  return json;
}

Json point_json(const FdkPlanPoint& point) {
  return {{"every", point.every},         {"rays", point.rays},           {"step", point.step},
          {"normalise", point.normalise}, {"error", point.error},         {"error_bound", point.error_bound},
          {"deposits", point.deposits},   {"board_ms", to_ms(point.time)}};
}

Json plan_json(const FdkPlan& plan) {
  Json json = target_json(plan.target, plan.kept);
  json.update(Json{{"chosen", point_json(plan.chosen)},
                   {"finest", point_json(plan.finest)},
                   {"slices", plan.slices},
                   {"pilots", plan.pilots},
                   {"pilot_deposits", plan.pilot_deposits},
                   {"host_seconds", plan.host_seconds}});
  for (const FdkPlanPoint& point : plan.points) json["points"].push_back(point_json(point));
  return json;
}

}  // namespace

Json statistics_of(const ReconstructOptions& options, const Scan& scan, const Reconstruction& result, const Json& cost,
                   const std::optional<FdkPlan>& plan) {
  const Grid& volume = scan.geometry.volume;
  const Json grid{{"dims", volume.dims}, {"spacing", numbers(volume.spacing)}, {"centre", numbers(scan.centre)}};
  Json json{{"scan", scan_json(scan)},
            {"volume", grid},
            {"method", options.method},
            {"settings", options.fdk() ? fdk_json(options.filtered) : algebraic_json(options.algebraic)},
            {"rays", result.rays},
            {"deposits", result.deposits},
            {"overflowed", result.overflowed},
            {"clipped", result.clipped},
            {"iterations", result.iterations},
            {"residuals", result.residuals},
            {"diverged", result.diverged},
            {"warnings", scan.warnings}};
  json.update(cost);
  json["plan"] = plan ? plan_json(*plan) : nullptr;
  return json;
}

}  // namespace gicube::samples

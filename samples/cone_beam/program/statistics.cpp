#include "cone_beam/program/statistics.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "scene/program/plan_options.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(Vec3 v) { return {v.x, v.y, v.z}; }

Json scan_json(const Scan& scan) {
  const ConeGeometry& geometry = scan.geometry;
  const Detector& detector = geometry.detector;
  Json json;
  json["views"] = geometry.angles.size();
  json["views_read"] = scan.views_read;
  json["repeated"] = scan.repeated;
  json["arc_degrees"] = (geometry.angles.back() - geometry.angles.front()) * 180 / std::numbers::pi;
  json["source_to_axis"] = geometry.source_to_axis;
  json["source_to_detector"] = geometry.source_to_detector;
  json["detector"] = {{"columns", detector.columns}, {"rows", detector.rows},         {"pitch_u", detector.pitch_u},
                      {"pitch_v", detector.pitch_v}, {"offset_u", detector.offset_u}, {"offset_v", detector.offset_v}};
  json["absorbed"] = scan.flat_field.absorbed;
  json["dead"] = scan.flat_field.dead;
  return json;
}

Json settings_json(const ReconstructOptions& options) {
  Json json;
  if (options.fdk) {
    const FdkSettings& fdk = options.filtered;
    constexpr std::array kWindows{"ram-lak", "shepp-logan", "hann"};
    json["window"] = kWindows[static_cast<std::size_t>(fdk.window)];
    json["rays"] = fdk.rays;
    json["step"] = fdk.step;
    json["sharpen"] = fdk.sharpen;
    json["normalise"] = fdk.normalise;
    json["accumulator"] = fdk.accumulator == Accumulator::kSums ? "sums" : "irradiance";
    if (fdk.accumulator == Accumulator::kIrradiance) {
      json["read_every"] = fdk.read_every;
      json["bits"] = fdk.bits;
      json["headroom"] = fdk.headroom;
    }
    return json;
  }
  const AlgebraicSettings& settings = options.algebraic;
  constexpr std::array kOrders{"sequential", "random", "golden"};
  json["iterations"] = settings.iterations;
  if (settings.method == Method::kOsSart) json["subsets"] = settings.subsets;
  json["relaxation"] = settings.relaxation;
  json["order"] = kOrders[static_cast<std::size_t>(settings.order)];
  json["non_negative"] = settings.non_negative;
  json["stop"] = settings.stop;
  json["noise_level"] = settings.noise;
  json["step"] = settings.step;
  json["seed"] = settings.seed;
  return json;
}

Json point_json(const FdkPlanPoint& point) {
  Json json;
  json["every"] = point.every;
  json["rays"] = point.rays;
  json["step"] = point.step;
  json["normalise"] = point.normalise;
  json["error"] = point.error;
  json["error_bound"] = point.error_bound;
  json["deposits"] = point.deposits;
  json["board_ms"] = to_ms(point.time);
  return json;
}

}  // namespace

const char* name_of(const ReconstructOptions& options) {
  if (options.fdk) return "fdk";
  switch (options.algebraic.method) {
    case Method::kSart: return "sart";
    case Method::kOsSart: return "os-sart";
    case Method::kSirt: return "sirt";
  }
  return "unknown";
}

Json to_json(const Cost& cost) {
  const auto value = [&](const char* name) { return cost.counters.value(name); };
  Json json;
  json["board_ms"] = to_ms(cost.simulated);
  json["bus_ms"] = to_ms(value("bus.down.busy_ps") + value("bus.up.busy_ps"));
  json["bus_down_bytes"] = value("bus.down.bytes");
  json["bus_up_bytes"] = value("bus.up.bytes");
  json["host_seconds"] = cost.host_seconds;
  json["board"] = {{"fidelity", name_of(cost.board.fidelity)},
                   {"config_hash", fmt::format("{:016x}", cost.board.config_hash)}};
  json["counters"] = to_json(cost.counters);
  return json;
}

Json to_json(const ReconstructOptions& options, const Scan& scan, const Reconstruction& result, const Cost& cost) {
  Json json;
  json["scan"] = scan_json(scan);
  const Grid& volume = scan.geometry.volume;
  json["volume"] = {{"dims", volume.dims}, {"spacing", numbers(volume.spacing)}, {"centre", numbers(scan.centre)}};
  json["method"] = name_of(options);
  json["settings"] = settings_json(options);
  json["rays"] = result.rays;
  json["deposits"] = result.deposits;
  json["overflowed"] = result.overflowed;
  json["clipped"] = result.clipped;
  json["iterations"] = result.iterations;
  json["residuals"] = result.residuals;
  json["diverged"] = result.diverged;
  json["warnings"] = scan.warnings;
  json.update(to_json(cost));
  return json;
}

Json to_json(const FdkPlan& plan) {
  Json json = target_json(plan.target, plan.kept);
  json["chosen"] = point_json(plan.chosen);
  json["finest"] = point_json(plan.finest);
  json["slices"] = plan.slices;
  json["pilots"] = plan.pilots;
  json["pilot_deposits"] = plan.pilot_deposits;
  json["host_seconds"] = plan.host_seconds;
  for (const FdkPlanPoint& point : plan.points) json["points"].push_back(point_json(point));
  return json;
}

Json to_json(const Comparison& comparison) {
  Json json;
  json["voxels"] = comparison.voxels;
  json["rmse"] = comparison.rmse;
  json["bias"] = comparison.bias;
  json["relative_l2"] = comparison.relative_l2;
  json["psnr"] = std::isfinite(comparison.psnr) ? Json(comparison.psnr) : Json(nullptr);
  json["ssim"] = comparison.ssim;
  return json;
}

}  // namespace gicube::samples

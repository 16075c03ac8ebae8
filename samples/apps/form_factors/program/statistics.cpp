#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "form_factors/program/options.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

// (emitted - sum of the balance) / emitted, the worst channel.
double balance_error(const EnergyBalance& energy) {
  double worst = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!(energy.emitted[c] > 0)) continue;
    const double became =
        energy.absorbed_by_faces[c] + energy.absorbed_by_medium[c] + energy.escaped[c] + energy.under_way[c];
    worst = std::max(worst, std::abs(energy.emitted[c] - became) / energy.emitted[c]);
  }
  return worst;
}

Json energy_json(const EnergyBalance& energy, double unit) {
  Json json;
  for (const auto& [name, power] : {std::pair{"emitted", energy.emitted},
                                    {"absorbed_by_faces", energy.absorbed_by_faces},
                                    {"absorbed_by_medium", energy.absorbed_by_medium},
                                    {"escaped", energy.escaped},
                                    {"under_way", energy.under_way},
                                    {"closure", energy.closure},
                                    {"measured_closure", energy.measured_closure}}) {
    json[name] = {power[0] * unit, power[1] * unit, power[2] * unit};
  }
  json["balance_error"] = balance_error(energy);
  return json;
}

// Errors of the incident light of elements, summed over channels, by weight.
Json error_json(const RadiosityResult& result) {
  double weights = 0, light = 0, errors = 0, greatest = 0;
  for (std::size_t i = 0; i < result.standard_error.size(); ++i) {
    const auto& [red, green, blue] = result.incident[i];
    const double weight = result.leaves[i].weight, error = result.standard_error[i];
    weights += weight;
    light += weight * (red + green + blue);
    errors += weight * error;
    greatest = std::max(greatest, error);
  }
  if (!(weights > 0)) return nullptr;
  return {{"mean", errors / weights},
          {"greatest", greatest},
          {"mean_incident", light / weights},
          {"relative", light > 0 ? Json(errors / light) : Json(nullptr)}};
}

Json settings_json(const RadiositySettings& settings) {
  return {{"solid_opacity", settings.solid_opacity},
          {"error", settings.error},
          {"rays", settings.rays},
          {"max_rays", settings.max_rays},
          {"step", settings.step},
          {"seed", settings.seed},
          {"solver", settings.solver == Solver::kShooting ? "shooting" : "gathering"},
          {"made", name_of(settings.made)},
          {"hierarchy", settings.hierarchy},
          {"convergence", settings.convergence},
          {"max_iterations", settings.max_iterations},
          {"leaf_voxels", settings.leaf_voxels}};
}

Json point_json(const RadiosityPlanPoint& point) {
  return {{"hierarchy", point.hierarchy},     {"threshold", point.threshold},   {"rays_a_link", point.rays},
          {"leaf_voxels", point.leaf_voxels}, {"difference", point.difference}, {"error", point.error},
          {"error_bound", point.error_bound}, {"rays", point.all_rays},         {"board_ms", to_ms(point.time)}};
}

Json plan_json(const RadiosityPlan& plan) {
  Json json = target_json(plan.target, plan.kept);
  json.update(Json{{"chosen", point_json(plan.chosen)},
                   {"full_matrix_rays", plan.finest_rays},
                   {"all_rays", plan.all_rays},
                   {"host_seconds", plan.host_seconds}});
  for (const RadiosityPlanPoint& point : plan.points) json["points"].push_back(point_json(point));
  return json;
}

}  // namespace

const char* name_of(PairRays made) { return made == PairRays::kByHost ? "host" : "board"; }

Utilisation utilisation_of(const Counters& counters, Picoseconds duration, const BoardInfo& board) {
  Utilisation out;
  if (duration == 0) return out;
  const auto of_time = [&](const char* name) {
    return static_cast<double>(counters.value(name)) / static_cast<double>(duration);
  };
  out.bus_down = of_time("bus.down.busy_ps");
  out.bus_up = of_time("bus.up.busy_ps");
  out.dsp = of_time("dsp.busy_ps");
  if (!counters.has("asic.cycles") || counters.value("asic.cycles") == 0) return out;
  // Cycles of the elapsed time; the ASIC does not count cycles without rays.
  const double cycles = static_cast<double>(duration) * 1e-9 * board.core_khz;
  const double working = static_cast<double>(counters.value("asic.cycles")) / cycles;
  out.pipelines = out.sorter = out.memory = 0;
  const std::string memory = memory_of(counters);
  for (int i = 0; i < board.processors; ++i) {
    const std::string processor = fmt::format("processor{}.", i), channel = fmt::format("{}{}.", memory, i);
    const double busy = static_cast<double>(counters.value(processor + "cycles.busy")) / cycles;
    if (busy > *out.pipelines) {
      out.pipelines = busy;
      out.sorter = static_cast<double>(counters.value(processor + "cycles.sorter")) / cycles;
    }
    const auto all = static_cast<double>(counters.value(channel + "cycles"));
    const double data = all > 0 ? static_cast<double>(counters.value(channel + "data_busy")) / all : 0;
    out.memory = std::max(*out.memory, working * data);
  }
  return out;
}

std::string Utilisation::bound() const {
  return std::max({std::pair<double, std::string>{bus_down + bus_up, "bus"},
                   {dsp, "DSP"},
                   {sorter.value_or(-1), "sorter"},
                   {pipelines.value_or(-1), "pipelines"},
                   {memory.value_or(-1), "memory"}})
      .second;
}

Json to_json(const Utilisation& utilisation) {
  const auto or_null = [](const std::optional<double>& share) { return share ? Json(*share) : Json(nullptr); };
  return {{"bus_down", utilisation.bus_down},
          {"bus_up", utilisation.bus_up},
          {"dsp", utilisation.dsp},
          {"sorter", or_null(utilisation.sorter)},
          {"pipelines", or_null(utilisation.pipelines)},
          {"memory", or_null(utilisation.memory)},
          {"bound", utilisation.bound()}};
}

Json statistics_of(const RadiosityResult& result, const RadiositySettings& settings, double area_unit,
                   const Counters& counters, const BoardInfo& board, const std::optional<RadiosityPlan>& plan) {
  const RadiosityStatistics& statistics = result.statistics;
  Json iterations = Json::array();
  for (const Iteration& iteration : statistics.iterations) {
    iterations.push_back({{"links", iteration.links}, {"residual", iteration.residual}});
  }
  const Json elements{{"faces", statistics.faces}, {"medium", statistics.medium}, {"ends", statistics.ends}};
  return {{"elements", elements},
          {"clusters", statistics.clusters},
          {"links", statistics.links},
          {"all_pairs", statistics.all_pairs},
          {"pairs", statistics.pairs},
          {"rays", statistics.rays},
          {"refinements", statistics.refinements},
          {"iterations", iterations},
          {"energy", energy_json(statistics.energy, area_unit)},
          {"closure_rms", statistics.closure_rms},
          {"standard_error", error_json(result)},
          {"bus_down_bytes", statistics.bus_down_bytes},
          {"bus_up_bytes", statistics.bus_up_bytes},
          {"board_ms", to_ms(statistics.board_time)},
          {"bus_ms", bus_ms(counters)},
          {"host_seconds", statistics.host_seconds},
          {"utilisation", to_json(utilisation_of(counters, statistics.board_time, board))},
          {"settings", settings_json(settings)},
          {"board", to_json(board)},
          {"counters", to_json(counters)},
          {"plan", plan ? plan_json(*plan) : nullptr},
          {"fidelity_report", fidelity_json(counters)}};
}

}  // namespace gicube::samples

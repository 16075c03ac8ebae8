#include "form_factors/program/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/program/memory_counters.h"
#include "scene/program/plan_options.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

double share(const Counters& counters, const std::string& part, const std::string& whole) {
  const double all = static_cast<double>(counters.value(whole));
  return all > 0 ? static_cast<double>(counters.value(part)) / all : 0;
}

Json scaled(const Power& power, double unit) { return {power[0] * unit, power[1] * unit, power[2] * unit}; }

Json energy_json(const EnergyBalance& energy, double unit) {
  Json json;
  json["emitted"] = scaled(energy.emitted, unit);
  json["absorbed_by_faces"] = scaled(energy.absorbed_by_faces, unit);
  json["absorbed_by_medium"] = scaled(energy.absorbed_by_medium, unit);
  json["escaped"] = scaled(energy.escaped, unit);
  json["under_way"] = scaled(energy.under_way, unit);
  json["closure"] = scaled(energy.closure, unit);
  json["measured_closure"] = scaled(energy.measured_closure, unit);
  json["balance_error"] = balance_error(energy);
  return json;
}

// Of the light that falls on elements, all channels together, by weight.
Json error_json(const RadiosityResult& result) {
  double weights = 0, light = 0, errors = 0, greatest = 0;
  for (std::size_t i = 0; i < result.leaves.size(); ++i) {
    if (i >= result.standard_error.size()) break;
    const Power& incident = result.incident[i];
    const double weight = result.leaves[i].weight, error = result.standard_error[i];
    weights += weight;
    light += weight * (incident[0] + incident[1] + incident[2]);
    errors += weight * error;
    greatest = std::max(greatest, error);
  }
  if (!(weights > 0)) return nullptr;
  Json json;
  json["mean"] = errors / weights;
  json["greatest"] = greatest;
  json["mean_incident"] = light / weights;
  json["relative"] = light > 0 ? Json(errors / light) : Json(nullptr);
  return json;
}

Json settings_json(const RadiositySettings& settings) {
  Json json;
  json["solid_opacity"] = settings.solid_opacity;
  json["error"] = settings.error;
  json["rays"] = settings.rays;
  json["most_rays"] = settings.max_rays;
  json["step"] = settings.step;
  json["seed"] = settings.seed;
  json["solver"] = settings.solver == Solver::kShooting ? "shooting" : "gathering";
  json["made"] = settings.made == PairRays::kByHost ? "host" : "board";
  json["hierarchy"] = settings.hierarchy;
  json["convergence"] = settings.convergence;
  json["max_iterations"] = settings.max_iterations;
  json["leaf_voxels"] = settings.leaf_voxels;
  return json;
}

Json point_json(const RadiosityPlanPoint& point) {
  Json json;
  json["hierarchy"] = point.hierarchy;
  json["threshold"] = point.threshold;
  json["rays_a_link"] = point.rays;
  json["leaf_voxels"] = point.leaf_voxels;
  json["difference"] = point.difference;
  json["error"] = point.error;
  json["error_bound"] = point.error_bound;
  json["rays"] = point.all_rays;
  json["board_ms"] = to_ms(point.time);
  return json;
}

}  // namespace

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
  // Of the time, not of the ASIC's own: it stands still while it has no rays.
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
    out.memory = std::max(*out.memory, working * share(counters, channel + "data_busy", channel + "cycles"));
  }
  return out;
}

std::string Utilisation::bound() const {
  std::pair<double, const char*> best{bus_down + bus_up, "bus"};
  const auto compare = [&best](double share, const char* name) { best = std::max(best, {share, name}); };
  compare(dsp, "DSP");
  if (sorter) compare(*sorter, "sorter");
  if (pipelines) compare(*pipelines, "pipelines");
  if (memory) compare(*memory, "memory");
  return best.second;
}

Json to_json(const Utilisation& utilisation) {
  const auto or_null = [](const std::optional<double>& share) { return share ? Json(*share) : Json(nullptr); };
  Json json;
  json["bus_down"] = utilisation.bus_down;
  json["bus_up"] = utilisation.bus_up;
  json["dsp"] = utilisation.dsp;
  json["sorter"] = or_null(utilisation.sorter);
  json["pipelines"] = or_null(utilisation.pipelines);
  json["memory"] = or_null(utilisation.memory);
  json["bound"] = utilisation.bound();
  return json;
}

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

Json to_json(const RadiosityResult& result, const RadiositySettings& settings, double area_unit,
             const Counters& counters, const BoardInfo& board) {
  const RadiosityStatistics& statistics = result.statistics;
  Json json;
  json["elements"] = {{"faces", statistics.faces}, {"medium", statistics.medium}, {"ends", statistics.ends}};
  json["clusters"] = statistics.clusters;
  json["links"] = statistics.links;
  json["all_pairs"] = statistics.all_pairs;
  json["pairs"] = statistics.pairs;
  json["rays"] = statistics.rays;
  json["refinements"] = statistics.refinements;
  json["iterations"] = Json::array();
  for (const Iteration& iteration : statistics.iterations) {
    json["iterations"].push_back({{"links", iteration.links}, {"residual", iteration.residual}});
  }
  json["energy"] = energy_json(statistics.energy, area_unit);
  json["closure_rms"] = statistics.closure_rms;
  json["standard_error"] = error_json(result);
  json["bus_down_bytes"] = statistics.bus_down_bytes;
  json["bus_up_bytes"] = statistics.bus_up_bytes;
  json["board_ms"] = to_ms(statistics.board_time);
  json["bus_ms"] = to_ms(counters.value("bus.down.busy_ps") + counters.value("bus.up.busy_ps"));
  json["host_seconds"] = statistics.host_seconds;
  json["utilisation"] = to_json(utilisation_of(counters, statistics.board_time, board));
  json["settings"] = settings_json(settings);
  json["board"] = {{"fidelity", name_of(board.fidelity)}, {"config_hash", fmt::format("{:016x}", board.config_hash)}};
  json["counters"] = to_json(counters);
  return json;
}

Json to_json(const RadiosityPlan& plan) {
  Json json = target_json(plan.target, plan.kept);
  json["chosen"] = point_json(plan.chosen);
  json["full_matrix_rays"] = plan.finest_rays;
  json["all_rays"] = plan.all_rays;
  json["host_seconds"] = plan.host_seconds;
  for (const RadiosityPlanPoint& point : plan.points) json["points"].push_back(point_json(point));
  return json;
}

}  // namespace gicube::samples

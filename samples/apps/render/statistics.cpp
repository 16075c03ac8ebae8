#include "render/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <unordered_map>
#include <utility>

#include "render/planning.h"
#include "scene/program/board_run.h"
#include "scene/program/bounds.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

Json counter_or_null(const Counters& counters, const char* name) {
  return counters.has(name) ? Json(counters.value(name)) : Json(nullptr);
}

double value(const FrameStatistics& statistics, const std::string& name) {
  return static_cast<double>(statistics.counters.value(name));
}

// Work of caches, memories and pipelines while the ASIC was active. Null where the level models no time for them.
void add_asic(const FrameStatistics& statistics, Json& json) {
  for (const char* key : {"samples_per_second", "throughput", "hit_ratio", "memory_gb_s", "memory_utilisation",
                          "load_balance", "dsp_utilisation"}) {
    json[key] = nullptr;
  }
  const Counters& counters = statistics.counters;
  if (!counters.has("asic.cycles") || counters.value("asic.cycles") == 0) return;
  const double cycles = value(statistics, "asic.cycles"), seconds = cycles / (statistics.board.core_khz * 1e3);
  const double samples = value(statistics, "processor.samples");
  json["samples_per_second"] = samples / seconds;
  json["throughput"] = samples / (cycles * statistics.board.processors);  // of the most that the pipelines could
  const double checks = value(statistics, "processor.cache.checks");
  if (checks > 0) json["hit_ratio"] = 1 - value(statistics, "processor.cache.missed_voxels") / (8 * checks);
  constexpr double kPacketBytes = 16;  // of 144 bits: the paper's unit, in which an RDRAM has 1.6 GB/s
  const std::string memory = memory_of(statistics.counters);
  const double packets = value(statistics, memory + ".reads") + value(statistics, memory + ".writes");
  json["memory_gb_s"] = packets * kPacketBytes / seconds * 1e-9;
  json["memory_utilisation"] = value(statistics, memory + ".data_busy") / value(statistics, memory + ".cycles");
  json["load_balance"] = value(statistics, "processor.rays_held") / (cycles * statistics.board.processors);  // [P §5.4]
  json["dsp_utilisation"] = value(statistics, "dsp.busy_ps") * 1e-12 / seconds;
}

Json by_face(const std::array<double, 6>& energy) {
  constexpr std::array kFaces{"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};
  Json json;
  for (std::size_t face = 0; face < kFaces.size(); ++face) json[kFaces[face]] = energy[face];
  return json;
}

// Energies of three irradiance words; null with one.
Json by_colour(const std::vector<LightEnergy>& colours) {
  if (colours.empty()) return nullptr;
  constexpr std::array kColours{"red", "green", "blue"};
  Json json;
  for (std::size_t c = 0; c < colours.size(); ++c) {
    const LightEnergy& energy = colours[c];
    json[kColours[c]] = {{"emitted", energy.emitted},   {"deposited", energy.deposited},
                         {"escaped", energy.escaped},   {"scattered_away", energy.scattered_away},
                         {"given_up", energy.given_up}, {"clipped", energy.clipped}};
  }
  return json;
}

Json lighting_json(const LightingStatistics& lighting) {
  const LightingReport& report = lighting.report;
  return {{"channel", lighting.channel},
          {"reused", lighting.reused},
          {"albedo", lighting.settings.albedo == Albedo::kHigh ? "high" : "low"},
          {"rules", lighting.settings.rules == EnergyRules::kConserving ? "conserving" : "as-printed"},
          {"rays_per_face_voxel", lighting.settings.rays_per_face_voxel},
          {"seed", lighting.settings.seed},
          {"lights", lighting.lights},
          {"pass_ms", to_ms(lighting.duration)},
          {"host_seconds", lighting.host_seconds},
          {"rays", report.rays},
          {"emitted", report.emitted},
          {"deposited", report.deposited},
          {"escaped", report.escaped},
          {"escaped_by_face", by_face(report.escaped_by_face)},
          {"scattered_away", report.scattered_away},
          {"given_up", report.given_up},
          {"clipped", report.clipped},
          {"unit", report.unit},
          {"colours", by_colour(report.colours)},
          {"warnings", report.warnings},
          {"energy", energy_json(lighting.counters)},
          {"power", power_json(lighting.counters, lighting.duration)},
          {"counters", to_json(lighting.counters)}};
}

Json detail_json(const std::optional<BrickDetail>& detail) {
  if (!detail) return nullptr;
  return {{"blocks", detail->blocks},  // as they are, in cells of 2^3, 4^3, 8^3 voxels
          {"largest_density", detail->largest_density},
          {"largest_opacity", detail->largest_opacity}};
}

Json boards_json(const FrameStatistics& statistics) {
  if (statistics.boards.empty()) return nullptr;
  Json json{{"buses", statistics.own_buses ? "own" : "shared"}, {"each", Json::array()}};
  for (const BoardTime& time : statistics.boards) {
    json["each"].push_back({{"bus_ms", to_ms(time.bus)},
                            {"work_ms", to_ms(time.work)},
                            {"bus_wait_ms", to_ms(time.bus_wait)},
                            {"skew_ms", to_ms(time.skew)}});
  }
  return json;
}

Json ranks_json(const std::vector<RankStatistics>& ranks) {
  if (ranks.empty()) return nullptr;
  Json json{{"imbalance", imbalance(ranks)}, {"each", Json::array()}};
  for (const RankStatistics& rank : ranks) {
    json["each"].push_back({{"work_ms", to_ms(rank.work)},
                            {"bus_ms", rank.bus_ms},
                            {"samples", rank.samples},
                            {"rays_sent", rank.rays_sent},
                            {"bytes_sent", rank.bytes_sent}});
  }
  return json;
}

}  // namespace

Counters sum_of(const std::vector<const Counters*>& windows) {
  std::vector<Counter> sum;
  std::unordered_map<std::string, std::size_t> place;
  for (const Counters* window : windows) {
    for (const Counter& counter : window->list()) {
      if (const auto [at, is_new] = place.emplace(counter.name, sum.size()); is_new) {
        sum.push_back(counter);
      } else {
        std::uint64_t& value = sum[at->second].value;
        value = is_maximum(counter) ? std::max(value, counter.value) : value + counter.value;
      }
    }
  }
  return Counters(std::move(sum));
}

Counters counters_of(std::span<const FrameStatistics> frames) {
  std::vector<const Counters*> windows;
  for (const FrameStatistics& frame : frames) {
    for (const LightingStatistics& lighting : frame.lighting) {
      if (!lighting.reused) windows.push_back(&lighting.counters);
    }
    windows.push_back(&frame.counters);
  }
  return sum_of(windows);
}

double imbalance(const std::vector<RankStatistics>& ranks) {
  double sum = 0, most = 0;
  for (const RankStatistics& rank : ranks) {
    sum += static_cast<double>(rank.samples);
    most = std::max(most, static_cast<double>(rank.samples));
  }
  return sum > 0 ? most * static_cast<double>(ranks.size()) / sum : 1;
}

std::string bound_of(const FrameStatistics& statistics) {
  return what_bounds(statistics.frame, statistics.counters, statistics.board, statistics.boards.size());
}

Json to_json(const FrameStatistics& statistics) {
  Json json;
  json["frame_ms"] = to_ms(statistics.frame);
  json["load_ms"] = to_ms(statistics.load);
  json["bus_ms"] = bus_ms(statistics.counters);
  json["host_seconds"] = statistics.host_seconds;
  json["samples"] = counter_or_null(statistics.counters, "pipeline.samples");
  add_asic(statistics, json);
  json["energy"] = energy_json(statistics.counters);
  json["power"] = power_json(statistics.counters, statistics.frame, statistics.boards.size());
  json["config_hash"] = fmt::format("{:016x}", statistics.board.config_hash);
  json["fidelity"] = name_of(statistics.board.fidelity);
  json["seed"] = statistics.seed;
  json["time"] = statistics.time;
  json["image"] = {{"width", statistics.width}, {"height", statistics.height}};
  json["volume"] = {{"dims", statistics.dims}};
  json["brick_detail"] = detail_json(statistics.detail);
  json["lighting"] = nullptr;
  for (const LightingStatistics& lighting : statistics.lighting) json["lighting"].push_back(lighting_json(lighting));
  json["plan"] = statistics.plan ? to_json(*statistics.plan) : Json(nullptr);
  for (const LightPlan& plan : statistics.light_plans) json["plan"]["light"].push_back(to_json(plan));
  json["boards"] = boards_json(statistics);
  json["ranks"] = ranks_json(statistics.ranks);
  json["host"] = statistics.host ? to_json(*statistics.host) : Json(nullptr);
  json["look"] = statistics.look.empty() ? Json(nullptr) : Json(statistics.look);
  json["bound"] = bound_of(statistics);
  json["invisible"] = statistics.invisible.empty() ? Json(nullptr) : Json(statistics.invisible);
  json["pixel"] = statistics.pixel;
  json["counters"] = to_json(statistics.counters);
  json["fidelity_report"] = fidelity_json(counters_of({&statistics, 1}));
  return json;
}

void write_statistics(const FrameStatistics& statistics, const std::filesystem::path& path) {
  write_json(to_json(statistics), provenance_of(statistics.board, statistics.scene_hash), path);
}

void write_statistics(const std::vector<FrameStatistics>& frames, const std::filesystem::path& path) {
  Json json;
  int passes = 0, loads = 0;
  json["illumination_passes"] = 0;
  json["volumes_loaded"] = 0;
  for (const FrameStatistics& frame : frames) {
    Json entry = to_json(frame);
    entry.erase("counters");
    for (const LightingStatistics& lighting : frame.lighting) passes += lighting.reused ? 0 : 1;
    for (Json& lighting : entry["lighting"]) lighting.erase("counters");
    loads += frame.load > 0 ? 1 : 0;
    json["frames"].push_back(std::move(entry));
  }
  json["illumination_passes"] = passes;
  json["volumes_loaded"] = loads;
  const Counters counters = counters_of(frames);
  json["counters"] = to_json(counters);
  json["fidelity_report"] = fidelity_json(counters);
  write_json(json, provenance_of(frames.front().board, frames.front().scene_hash), path);
}

}  // namespace gicube::samples

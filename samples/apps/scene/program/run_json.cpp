#include "scene/program/run_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "gicube/fidelity.h"
#include "scene/common/whole_file.h"
#include "scene/program/board_options.h"
#include "scene/program/board_run.h"
#include "scene/program/bounds.h"

namespace gicube::samples {

nlohmann::ordered_json to_json(const Counters& counters) {
  auto json = nlohmann::ordered_json::object();
  for (const Counter& counter : counters.list())
    json[counter.name] = {{"value", counter.value}, {"unit", counter.unit}};
  return json;
}

nlohmann::ordered_json to_json(const BoardInfo& board) {
  return {{"fidelity", name_of(board.fidelity)}, {"config_hash", hex(board.config_hash)}};
}

nlohmann::ordered_json fidelity_json(const Counters& counters) {
  auto levels = nlohmann::ordered_json::array();
  for (const LevelReport& report : fidelity_report(counters)) {
    nlohmann::ordered_json level{{"level", name_of(report.level)}, {"answered", nlohmann::ordered_json::object()}};
    for (const AnsweredCommand& each : report.answered) {
      level["answered"][each.command.empty() ? "any" : each.command] = each.count;
    }
    level["not_modelled"] = report.not_modelled;
    levels.push_back(std::move(level));
  }
  return levels;
}

double bus_ms(const Counters& counters) {
  return to_ms(counters.value("bus.down.busy_ps") + counters.value("bus.up.busy_ps"));
}

namespace {

constexpr double kSlotWatts = 25;  // PCI 2.2, §4.4.2.2: the most that a board may take
constexpr std::string_view kEnergy = "energy.", kEnergyTotal = "energy.total";

constexpr double kPackageWatts = 3;  // chosen: the power of a package of 2000 without a fan (docs/guide/energy.md)

// Parts of the ASIC. Among the other chips only the DSP may approach its package's limit: a memory device takes at most
// 1.25 W.
constexpr std::array<std::string_view, 9> kAsicParts{"memory_interface", "queues", "sorters", "cache",  "tables",
                                                     "pipelines",        "links",  "clock",   "leakage"};

// Joules or watts.
struct Figure {
  double value = 0, low = 0, high = 0;

  Figure& operator+=(const Figure& other) {
    value += other.value, low += other.low, high += other.high;
    return *this;
  }
  Figure operator*(double scale) const { return {value * scale, low * scale, high * scale}; }
};

void to_json(nlohmann::ordered_json& json, const Figure& figure) {
  json = {{"value", figure.value}, {"low", figure.low}, {"high", figure.high}};
}

// Joules of a part, or "total".
Figure joules_of(const Counters& counters, const std::string& part) {
  const std::string name = std::string(kEnergy) + part;
  const auto joules = [&](const char* end) { return static_cast<double>(counters.value(name + end)) * 1e-12; };
  return {joules(""), joules(".low"), joules(".high")};
}

// The peak watts of a part, or "total", of all boards together. Nothing for the host bus.
std::optional<Figure> peak_of(const Counters& counters, const std::string& part) {
  const std::string name = std::string(kEnergy) + part + ".peak";
  const auto watts = [&](const char* end) { return static_cast<double>(counters.value(name + end)) * 1e-6; };
  if (!counters.has(name) || counters.value(name) == 0) return std::nullopt;
  return Figure{watts(""), watts("_low"), watts("_high")};
}

// The largest first.
std::vector<std::string> parts_of(const Counters& counters) {
  std::vector<std::string> parts;
  for (const Counter& counter : counters.list()) {
    const bool is_part =
        counter.name.starts_with(kEnergy) && counter.name.find('.', kEnergy.size()) == std::string::npos;
    if (is_part && counter.name != kEnergyTotal) parts.push_back(counter.name.substr(kEnergy.size()));
  }
  std::ranges::stable_sort(parts, std::greater{}, [&](const auto& part) { return joules_of(counters, part).value; });
  return parts;
}

}  // namespace

nlohmann::ordered_json energy_json(const Counters& counters) {
  if (!counters.has(kEnergyTotal)) return nullptr;
  const Figure total = joules_of(counters, "total");
  const auto of_each = [&](const char* count) {
    const std::uint64_t all = counters.value(count);
    return all > 0 ? nlohmann::ordered_json(total.value / static_cast<double>(all)) : nullptr;
  };
  return {{"joules", total},
          {"joules_per_sample", of_each("pipeline.samples")},
          {"joules_per_ray", of_each("pipeline.rays")}};
}

nlohmann::ordered_json power_json(const Counters& counters, Picoseconds time, std::size_t boards) {
  if (!counters.has(kEnergyTotal) || time == 0) return nullptr;
  const double count = static_cast<double>(std::max<std::size_t>(boards, 1));
  const double each_second = 1e12 / static_cast<double>(time) / count;
  const auto with_peak = [&](const std::string& part) {
    nlohmann::ordered_json json{{"mean", joules_of(counters, part) * each_second}, {"peak", nullptr}};
    if (const auto peak = peak_of(counters, part)) json["peak"] = *peak * (1 / count);
    return json;
  };
  nlohmann::ordered_json json = with_peak("total");
  Figure asic, dsp;
  for (const std::string& part : parts_of(counters)) {
    json["parts"][part] = with_peak(part);
    if (std::ranges::find(kAsicParts, part) != kAsicParts.end()) asic += joules_of(counters, part) * each_second;
    if (part == "dsp") dsp = joules_of(counters, part) * each_second;
  }
  json["asic"] = asic;
  const auto& most = json.at(json.at("peak").is_null() ? "mean" : "peak");
  json["within_slot"] = most.at("high").get<double>() <= kSlotWatts;
  json["within_packages"] = std::max(asic.high, dsp.high) <= kPackageWatts;
  return json;
}

std::string energy_line(const Counters& counters, Picoseconds time, std::size_t boards) {
  const auto energy = energy_json(counters), power = power_json(counters, time, boards);
  if (power.is_null()) return {};
  const auto watts = [&power](const char* path) { return power.at(nlohmann::json::json_pointer(path)).get<double>(); };
  const auto microjoules = [&energy](const char* name, const char* what) {
    const auto& each = energy.at(name);
    return each.is_null() ? std::string() : fmt::format(", {:.3g} uJ a {}", each.get<double>() * 1e6, what);
  };
  const std::string peak = power.at("peak").is_null() ? "" : fmt::format(", peak {:.1f} W", watts("/peak/value"));
  const std::vector<std::string> parts = parts_of(counters);
  return fmt::format(
      "{:.1f} mJ{}{}: {:.1f} W ({:.1f} to {:.1f}){}, most of it {} and {}; ASIC {:.1f} W (up to {:.1f}); the slot's "
      "{:.0f} W {}, packages without a fan ({:.0f} W) {}",
      energy.at("joules").at("value").get<double>() * 1e3, microjoules("joules_per_sample", "sample"),
      microjoules("joules_per_ray", "ray"), watts("/mean/value"), watts("/mean/low"), watts("/mean/high"), peak,
      parts.at(0), parts.at(1), watts("/asic/value"), watts("/asic/high"), kSlotWatts,
      power.at("within_slot").get<bool>() ? "suffice" : "may not suffice", kPackageWatts,
      power.at("within_packages").get<bool>() ? "suffice" : "may not suffice");
}

std::string memory_of(const Counters& counters) {
  constexpr std::string_view kEnd = ".data_busy";
  for (const Counter& counter : counters.list()) {
    if (!counter.name.ends_with(kEnd)) continue;
    const std::string name = counter.name.substr(0, counter.name.size() - kEnd.size());
    if (!name.empty() && std::isdigit(static_cast<unsigned char>(name.back())) == 0) return name;
  }
  return {};
}

nlohmann::ordered_json cost_json(const BoardInfo& board, RunWindow& window) {
  const Counters counters = window.counters();
  return {{"board_ms", to_ms(window.simulated())},
          {"bus_ms", bus_ms(counters)},
          {"bus_down_bytes", counters.value("bus.down.bytes")},
          {"bus_up_bytes", counters.value("bus.up.bytes")},
          {"host_seconds", window.host_seconds()},
          {"board", to_json(board)},
          {"bound", what_bounds(window.simulated(), counters, board)},
          {"counters", to_json(counters)},
          {"energy", energy_json(counters)},
          {"power", power_json(counters, window.simulated())},
          {"fidelity_report", fidelity_json(counters)}};
}

Provenance provenance_of(const BoardInfo& board, std::uint64_t scene_hash) {
  Provenance provenance = this_run();
  provenance.config_hash = hex(board.config_hash);
  provenance.fidelity = name_of(board.fidelity);
  provenance.scene_hash = hex(scene_hash);
  return provenance;
}

void write_json(nlohmann::ordered_json json, const Provenance& provenance, const std::filesystem::path& path) {
  constexpr std::string_view kPrefix = "gicube.";
  for (const auto& [key, value] : entries(provenance)) json["provenance"][key.substr(kPrefix.size())] = value;
  write_whole(path, json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
}

}  // namespace gicube::samples

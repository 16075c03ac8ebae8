#include "scene/program/run_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
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

// Parts of the ASIC. Its package of 2000 sheds some 3 W without a fan (docs/guide/energy.md).
constexpr std::array<std::string_view, 9> kAsicParts{"memory_interface", "queues", "sorters", "cache",  "tables",
                                                     "pipelines",        "links",  "clock",   "leakage"};

struct PartOfEnergy {
  std::string name;
  double joules, low, high;
};

PartOfEnergy energy_of(const Counters& counters, const std::string& counter) {
  const auto joules = [&](const char* end) { return static_cast<double>(counters.value(counter + end)) * 1e-12; };
  return {counter.substr(kEnergy.size()), joules(""), joules(".low"), joules(".high")};
}

// The largest first.
std::vector<PartOfEnergy> energy_parts(const Counters& counters) {
  std::vector<PartOfEnergy> parts;
  for (const Counter& counter : counters.list()) {
    const bool is_part =
        counter.name.starts_with(kEnergy) && counter.name.find('.', kEnergy.size()) == std::string::npos;
    if (is_part && counter.name != kEnergyTotal) parts.push_back(energy_of(counters, counter.name));
  }
  std::ranges::stable_sort(parts, std::greater{}, &PartOfEnergy::joules);
  return parts;
}

}  // namespace

nlohmann::ordered_json energy_json(const Counters& counters, Picoseconds time) {
  if (!counters.has(std::string(kEnergyTotal)) || time == 0) return nullptr;
  const double seconds = static_cast<double>(time) * 1e-12;
  const PartOfEnergy total = energy_of(counters, std::string(kEnergyTotal));
  const auto with_bounds = [](const PartOfEnergy& of, double scale) {
    return nlohmann::ordered_json{{"value", of.joules * scale}, {"low", of.low * scale}, {"high", of.high * scale}};
  };
  nlohmann::ordered_json json{{"joules", with_bounds(total, 1)}, {"watts", with_bounds(total, 1 / seconds)}};
  json["within_slot"] = total.high / seconds <= kSlotWatts;
  double asic = 0;
  for (const PartOfEnergy& part : energy_parts(counters)) {
    json["parts"][part.name] = with_bounds(part, 1 / seconds);
    if (std::ranges::find(kAsicParts, part.name) != kAsicParts.end()) asic += part.joules / seconds;
  }
  json["asic_watts"] = asic;
  return json;
}

std::string energy_line(const Counters& counters, Picoseconds time) {
  const auto json = energy_json(counters, time);
  if (json.is_null()) return {};
  const auto& watts = json.at("watts");
  const std::vector<PartOfEnergy> parts = energy_parts(counters);
  return fmt::format("{:.1f} W ({:.1f} to {:.1f}), most of it {} and {}; ASIC {:.1f} W; the slot's {:.0f} W {}",
                     watts.at("value").get<double>(), watts.at("low").get<double>(), watts.at("high").get<double>(),
                     parts.at(0).name, parts.at(1).name, json.at("asic_watts").get<double>(), kSlotWatts,
                     json.at("within_slot").get<bool>() ? "suffice" : "may not suffice");
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
          {"energy", energy_json(counters, window.simulated())},
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

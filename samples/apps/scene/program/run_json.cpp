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

constexpr double kPackageWatts = 3;  // chosen: what a package of 2000 sheds without a fan (docs/guide/energy.md)

// Parts of the ASIC. Of the other chips only the DSP comes near its package: a memory device takes at most 1.25 W.
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

nlohmann::ordered_json energy_json(const Counters& counters, Picoseconds time, std::size_t boards) {
  if (!counters.has(std::string(kEnergyTotal)) || time == 0) return nullptr;
  const double seconds = static_cast<double>(time) * 1e-12;
  const double board_seconds = seconds * static_cast<double>(std::max<std::size_t>(boards, 1));
  const PartOfEnergy total = energy_of(counters, std::string(kEnergyTotal));
  const auto with_bounds = [](const PartOfEnergy& of, double scale) {
    return nlohmann::ordered_json{{"value", of.joules * scale}, {"low", of.low * scale}, {"high", of.high * scale}};
  };
  nlohmann::ordered_json json{{"joules", with_bounds(total, 1)}, {"watts", with_bounds(total, 1 / seconds)}};
  const auto of_each = [&](const char* count) {
    const std::uint64_t all = counters.value(count);
    return all > 0 ? nlohmann::ordered_json(total.joules / static_cast<double>(all)) : nullptr;
  };
  json["joules_per_sample"] = of_each("pipeline.samples");
  json["joules_per_ray"] = of_each("pipeline.rays");
  PartOfEnergy asic{"asic", 0, 0, 0}, dsp{"dsp", 0, 0, 0};
  for (const PartOfEnergy& part : energy_parts(counters)) {
    json["parts"][part.name] = with_bounds(part, 1 / seconds);
    const bool is_asic = std::ranges::find(kAsicParts, part.name) != kAsicParts.end();
    if (!is_asic && part.name != dsp.name) continue;
    PartOfEnergy& chip = is_asic ? asic : dsp;
    chip.joules += part.joules, chip.low += part.low, chip.high += part.high;
  }
  json["within_slot"] = total.high / board_seconds <= kSlotWatts;
  json["within_packages"] = std::max(asic.high, dsp.high) / board_seconds <= kPackageWatts;
  json["asic_watts"] = asic.joules / board_seconds;
  json["asic_most_watts"] = asic.high / board_seconds;
  return json;
}

std::string energy_line(const Counters& counters, Picoseconds time, std::size_t boards) {
  const auto json = energy_json(counters, time, boards);
  if (json.is_null()) return {};
  const auto number = [&json](const char* path) { return json.at(nlohmann::json::json_pointer(path)).get<double>(); };
  const auto microjoules = [&json](const char* name, const char* what) {
    const auto& each = json.at(name);
    return each.is_null() ? std::string() : fmt::format(", {:.3g} uJ a {}", each.get<double>() * 1e6, what);
  };
  const std::vector<PartOfEnergy> parts = energy_parts(counters);
  return fmt::format(
      "{:.1f} mJ{}{}: {:.1f} W ({:.1f} to {:.1f}), most of it {} and {}; ASIC {:.1f} W (up to {:.1f}); the slot's "
      "{:.0f} W "
      "{}, packages without a fan ({:.0f} W) {}",
      number("/joules/value") * 1e3, microjoules("joules_per_sample", "sample"), microjoules("joules_per_ray", "ray"),
      number("/watts/value"), number("/watts/low"), number("/watts/high"), parts.at(0).name, parts.at(1).name,
      number("/asic_watts"), number("/asic_most_watts"), kSlotWatts,
      json.at("within_slot").get<bool>() ? "suffice" : "may not suffice", kPackageWatts,
      json.at("within_packages").get<bool>() ? "suffice" : "may not suffice");
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

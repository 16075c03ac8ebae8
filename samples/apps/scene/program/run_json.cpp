#include "scene/program/run_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "gicube/fidelity.h"
#include "scene/common/whole_file.h"
#include "scene/program/board_options.h"
#include "scene/program/board_run.h"

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
          {"counters", to_json(counters)},
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

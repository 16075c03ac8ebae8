// gicube-smi without a command: all boards of this user on this machine.
#include <fmt/format.h>

#include "gicube/registry.h"
#include "local_boards.h"
#include "options.h"
#include "output.h"
#include "transport/pci_devices.h"

namespace gicube::smi {
namespace {

// A private board has no place where others could open it.
std::string place_of(const v1::BoardInfo& board) {
  return board.bus_endpoint().starts_with("fd:") ? "private" : board.bus_endpoint();
}

void print_table(const std::vector<LocalProcess>& processes, const std::vector<PciDevice>& functions) {
  Table table({{"PID", Align::kRight},
               {"BOARD", Align::kRight},
               {"NAME"},
               {"OPEN WITH"},
               {"FIDELITY"},
               {"BUS"},
               {"SIMULATED", Align::kRight},
               {"CONFIGURATION"},
               {"MANAGEMENT"},
               {"STATE"}});
  for (const LocalProcess& process : processes) {
    const std::string pid = std::to_string(process.pid);
    if (!process.told) {
      table.add({pid, "", "", "", "", "", "", "", "", "does not answer"});
      continue;
    }
    const v1::BoardProcess& told = *process.told;
    for (int i = 0; i < told.boards_size(); ++i) {
      const v1::BoardInfo& board = told.boards(i);
      const std::uint64_t simulated = i < told.counters_size() ? told.counters(i).simulated_ps() : 0;
      table.add({pid, std::to_string(board.board()), board.product(), place_of(board),
                 v1::FidelityLevel_Name(board.config().fidelity()), v1::BusModel_Name(board.config().bus().model()),
                 time_text(static_cast<double>(simulated)), board.config_hash(),
                 told.management_endpoint().empty() ? "none" : told.management_endpoint(),
                 board.in_use() ? "in use by " + board.owner() : "free"});
    }
  }
  for (const auto& [address, in_use] : functions) {
    table.add({"", "", "GI-Cube (PCI function)", "pci:" + address, "", "", "", "", "none", in_use ? "in use" : "free"});
  }
  if (table.empty()) return fmt::print("no board of this user runs on this machine ({})\n", registry_folder());
  fmt::print("{}", table.text());
}

void print_json(const std::vector<LocalProcess>& processes, const std::vector<PciDevice>& functions) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const LocalProcess& process : processes) {
    nlohmann::ordered_json entry{{"pid", process.pid}, {"answers", process.told.has_value()}};
    if (process.told) {
      entry.update(to_json(*process.told));
      entry["counters"] = nlohmann::ordered_json::array();
      for (const v1::CounterSnapshot& counters : process.told->counters())
        entry["counters"].push_back(to_json(counters));
    }
    list.push_back(std::move(entry));
  }
  nlohmann::ordered_json pci = nlohmann::ordered_json::array();
  for (const auto& [address, in_use] : functions) pci.push_back({{"uri", "pci:" + address}, {"in_use", in_use}});
  print({{"registry", registry_folder()}, {"processes", std::move(list)}, {"functions", std::move(pci)}});
}

}  // namespace

int overview(const Options& options) {
  const std::vector<LocalProcess> processes = local_processes();
  const std::vector<PciDevice> functions = pci_devices();
  if (options.json) {
    print_json(processes, functions);
  } else {
    print_table(processes, functions);
  }
  return 0;
}

}  // namespace gicube::smi

#include "local_boards.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "options.h"
#include "transport/board_processes.h"

namespace gicube::smi {

std::vector<LocalProcess> local_processes() {
  std::vector<LocalProcess> processes;
  for (const BoardProcess& each : board_processes()) {
    LocalProcess& process = processes.emplace_back();
    process.pid = each.id;
    v1::BoardProcess told;
    if (each.answer && told.ParseFromString(*each.answer)) process.told = std::move(told);
  }
  return processes;
}

std::string only_management_endpoint() {
  std::vector<std::string> endpoints;
  for (const LocalProcess& process : local_processes()) {
    if (process.told && !process.told->management_endpoint().empty())
      endpoints.push_back(process.told->management_endpoint());
  }
  if (endpoints.size() == 1) return endpoints.front();
  throw UsageError(
      endpoints.empty()
          ? "--management: expected a management plane, got none, and no board of this user on this machine "
            "has one (gicube-board --management unix:PATH)"
          : fmt::format("--management: expected one of {}, got none", fmt::join(endpoints, ", ")));
}

}  // namespace gicube::smi

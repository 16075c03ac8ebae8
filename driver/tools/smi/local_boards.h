// The board processes of this user on this machine, and their descriptions of themselves (transport/board_processes.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gicube/v1/management.pb.h"

namespace gicube::smi {

struct LocalProcess {
  std::uint32_t pid = 0;
  std::optional<v1::BoardProcess> told;  // nothing if it has not answered in time
};

// By process id. Throws Error if the registry can't be trusted.
std::vector<LocalProcess> local_processes();

// The management plane of the only process that has one. Otherwise throws UsageError with those of all processes.
// Throws as local_processes() too.
std::string only_management_endpoint();

}  // namespace gicube::smi

// The board processes of this user on this machine, by their sockets in the registry (proto/gicube/registry.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gicube/v1/management.pb.h"

namespace gicube::smi {

struct LocalProcess {
  std::uint32_t pid = 0;
  std::optional<v1::BoardProcess> told;  // nothing: it is there, but has not answered in time
};

// By process id. Removes what killed processes have left. Throws CallFailed if the registry can't be trusted.
std::vector<LocalProcess> local_processes();

// The management plane of the only one that has one. Throws UsageError that names those that there are, and as
// local_processes().
std::string only_management_endpoint();

}  // namespace gicube::smi

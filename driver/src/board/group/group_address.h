// Parses the address of a group of boards.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/board_group.h"

namespace gicube {

struct GroupAddress {
  std::vector<std::string> boards;  // one address each
  std::optional<HostBuses> buses;   // empty: the address does not say
};

// Throws BadArgument (boards, buses).
GroupAddress parse_group(std::string_view address);

}  // namespace gicube

// The board processes of this user on this machine, by their sockets in the registry (proto/gicube/registry.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gicube {

struct BoardProcess {
  std::uint32_t id = 0;
  std::optional<std::string> answer;  // a gicube.v1.BoardProcess; nothing: it has not answered within two seconds
};

// By process id. All are asked at once, so one that hangs does not hide the others. Removes the sockets that killed
// processes have left. Throws Error if the registry can't be trusted.
std::vector<BoardProcess> board_processes();

}  // namespace gicube

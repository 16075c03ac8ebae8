// The fidelity levels that answered a run's commands, and the parts that their figures omit.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/counters.h"
#include "gicube/export.h"

namespace gicube {

struct AnsweredCommand {  // how many commands of a kind a level answered
  // "render", "trace", "illuminate", "resume", "pairs", "continue"; empty: the board does not report it.
  std::string command;
  std::uint64_t count = 0;
};

struct LevelReport {  // the commands of a level, and the parts that it omits
  Fidelity level = Fidelity::kFunctional;
  std::vector<AnsweredCommand> answered;
  std::vector<std::string> not_modelled;  // at that level: docs/reference/hardware.md
};

// An entry for each level that has answered a command, from functional to cycle. `window`: of the run (Counters). Empty
// if it has no command with rays.
GICUBE_API std::vector<LevelReport> fidelity_report(const Counters& window);

}  // namespace gicube

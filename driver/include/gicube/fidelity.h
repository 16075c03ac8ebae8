// Which fidelity level answered, and what its figures leave out: for what a program writes about a run.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/counters.h"
#include "gicube/export.h"

namespace gicube {

struct AnsweredCommand {
  // "render", "trace", "illuminate", "resume", "pairs", "continue"; empty: of a board that does not tell.
  std::string command;
  std::uint64_t count = 0;
};

// The largest error against the cycle level that was measured; what a run's own scene has may be another.
struct MeasuredBound {
  std::string quantity;     // as "time"
  double within = 0;        // of the quantity, 0.024 for 2.4%, or in its own units
  bool relative = true;     // which of them
  std::string measured_on;  // scenes and configurations
  std::string source;       // the document that states it
};

struct LevelReport {
  Fidelity level = Fidelity::kFunctional;
  std::vector<AnsweredCommand> answered;
  std::vector<std::string> not_modelled;  // at that level: docs/reference/hardware.md
  std::vector<MeasuredBound> estimates;   // empty unless the level estimates
};

// An entry for each level that has answered a command, from functional to cycle; a board of level approximate hands some to the
// cycle level. `window`: of the run (Counters). Empty if it has no command with rays.
GICUBE_API std::vector<LevelReport> fidelity_report(const Counters& window);

}  // namespace gicube

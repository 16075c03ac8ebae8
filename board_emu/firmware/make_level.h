// The one place that names the fidelity levels.
#pragma once

#include <memory>

#include "gicube/v1/board_config.pb.h"
#include "levels/level.h"

namespace gicube::emu {

class Observer;

// The level that `config` asks for. `observer` sees the cycles of levels that have them; null for none. Both must outlive it.
std::unique_ptr<Level> make_level(const v1::BoardConfig& config, Observer* observer);

}  // namespace gicube::emu

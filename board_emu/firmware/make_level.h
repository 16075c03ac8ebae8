// Creates the fidelity level. Only this part includes the single levels.
#pragma once

#include <memory>

#include "gicube/v1/board_config.pb.h"
#include "levels/level.h"

namespace gicube::emu {

class Observer;

// Creates the level selected by `config`. `observer` observes the cycles of levels that have cycles; may be null. Both
// must outlive the level.
std::unique_ptr<Level> make_level(const v1::BoardConfig& config, Observer* observer);

}  // namespace gicube::emu

// A board's configuration for people.
#pragma once

#include <string>

#include "gicube/v1/board_config.pb.h"

namespace gicube::smi {

// One field a line, "asic.processors  8", with "(default 4)" behind those that are not the design point's.
std::string configuration_text(const v1::BoardConfig& config);

// The name of an enumeration's value: "agp2x".
std::string bus_name(const v1::BoardConfig& config);
std::string fidelity_name(const v1::BoardConfig& config);

}  // namespace gicube::smi

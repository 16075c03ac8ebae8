// Text form of a pixel's rays and their iterations.
#pragma once

#include <string>

#include "firmware/pixel_life.h"

namespace gicube::emu {

// Returns a JSON object in one line. docs/guide/observation.md lists its fields.
std::string to_json(const PixelLife& life);

}  // namespace gicube::emu

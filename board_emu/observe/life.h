// The life of a pixel's rays as text.
#pragma once

#include <string>

#include "firmware/pixel_life.h"

namespace gicube::emu {

// A JSON object in one line; docs/guide/observation.md has its fields.
std::string to_json(const PixelLife& life);

}  // namespace gicube::emu

// Simulated time, never the wall clock.
#pragma once

#include <cstdint>

#include "gicube/export.h"

namespace gicube {

// Picoseconds since the board was opened.
using Picoseconds = std::uint64_t;

// A deadline that never passes.
inline constexpr Picoseconds kNoDeadline = ~Picoseconds{0};

constexpr double to_ms(Picoseconds time) { return static_cast<double>(time) * 1e-9; }

}  // namespace gicube

// What a command brought about, and what it costs.
#pragma once

#include <cstdint>
#include <vector>

#include "gicube/wire/frame.h"
#include "words/clock.h"

namespace gicube::emu {

struct CommandResult {
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::vector<std::uint8_t> payload{};  // of the completion; with an error: its text
  std::uint64_t dsp_cycles = 0;
  Picoseconds asic_ps = 0;     // how long the ASIC works at it; 0 at the functional level
  std::uint64_t up_bytes = 4;  // at least the completion word in the host's memory
  bool takes_rays = false;
  bool returns_rays = false;
  bool leaves_nothing = false;  // but what it returns: it may be taken back
};

}  // namespace gicube::emu

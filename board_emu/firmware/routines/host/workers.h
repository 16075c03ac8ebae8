// The copies of the process that make the calls.
#pragma once

#include "firmware/routines/call_memory.h"

namespace gicube::emu {

// Begins and ends them as the board orders, and says which have ended. Until the board goes; none is left then.
void serve_orders(CallMemory& memory, const gicube_bsdf& routine, bool is_boxed);

}  // namespace gicube::emu

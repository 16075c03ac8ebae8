// The plug-in's code: loaded, asked what it is, and called.
#pragma once

#include "firmware/routines/call_memory.h"

namespace gicube::emu {

// Loads the library, and reports its description or what is wrong. Null: it can't be used.
const gicube_bsdf* load(const char* file, Loading& report);

// The slot's call.
void answer(const gicube_bsdf& routine, CallSlot& slot);

}  // namespace gicube::emu

// What the plug-in's process may do, and how long it lives.
#pragma once

#include "firmware/routines/call_memory.h"

namespace gicube::emu {

// What the board has given, or null.
CallMemory* shared_memory();

// Before the plug-in's library is loaded: no capability, none to be had by executing anything. Signals of a terminal or a service
// manager are the board's to take.
void give_up_rights();

// Whether the process ends when the thread that started it does.
void end_with_parent(bool does);

// Of a process that will only make calls, after the library was loaded and before the first call: it gives up the other calls' memory, all
// descriptors, and with `is_boxed` all but computing (box/box.h): no file, no network, no other process.
void enter_call_box(CallMemory& memory, const CallSlot& own, bool is_boxed);

}  // namespace gicube::emu

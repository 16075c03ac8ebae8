// The parts of gicube-plug-in-host: the process's rights and lifetime, loading the plug-in, and calling it.
#pragma once

#include "gicube/observer.h"
#include "plug_ins/call_memory.h"

namespace gicube::emu {

// Returns the memory shared with the board, or null if there is none.
CallMemory* shared_memory();

// To be called before the plug-in's library is loaded. Afterwards the process cannot gain rights by executing programs,
// and a routine has no capabilities. Signals of a terminal or a service manager are ignored, because the board handles
// them.
void give_up_rights(bool is_observer);

// Sets whether the process ends with the thread that started it.
void end_with_parent(bool does);

// Load the library, and report its description or the fault. Return null if it cannot be used.
const gicube_bsdf* load_routine(const char* file, Loading& report);
const gicube_observer* load_observer(const char* file, Loading& report);

// Forks and ends the processes that make a routine's calls, as the board orders, and reports those that have ended.
// Returns when the board has ended; no such process is left then. A forked process has only the memory of its own calls
// and no descriptor. With `is_boxed` it can only compute (box/box.h): no files, no network, no other process.
void serve_orders(CallMemory& memory, const gicube_bsdf& routine, bool is_boxed);

// Passes the board's events to the observer until the board ends. Returns the process's exit code.
int serve_events(const gicube_observer& observer, const char* file);

}  // namespace gicube::emu

// The parts of gicube-plug-in-host: what the process may do and how long it lives, the plug-in's code, and how that is
// called.
#pragma once

#include "gicube/observer.h"
#include "plug_ins/call_memory.h"

namespace gicube::emu {

// Returns the memory that the board has given, or null.
CallMemory* shared_memory();

// Before the plug-in's library is loaded: no rights are to be had by executing anything, and a routine has no
// capability. Signals of a terminal or a service manager are the board's to take.
void give_up_rights(bool is_observer);

// Whether the process ends when the thread that started it does.
void end_with_parent(bool does);

// Load the library, and report its description or what is wrong. Null: it can't be used.
const gicube_bsdf* load_routine(const char* file, Loading& report);
const gicube_observer* load_observer(const char* file, Loading& report);

// Begins and ends the copies of the process that make a routine's calls, as the board orders, and says which have
// ended. Until the board goes; none is left then. A copy has none of the other calls' memory and no descriptor, and
// with `is_boxed` it can only compute (box/box.h): no file, no network, no other process.
void serve_orders(CallMemory& memory, const gicube_bsdf& routine, bool is_boxed);

// Hands the board's events to the observer until the board goes. Returns the process's exit code.
int serve_events(const gicube_observer& observer, const char* file);

}  // namespace gicube::emu

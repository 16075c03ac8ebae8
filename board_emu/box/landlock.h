// Files and TCP of this process, bounded by the kernel's Landlock.
#pragma once

#include <vector>

#include "box.h"

namespace gicube::emu {

// Leaves every thread of the process these places, nothing to execute, and no TCP port to bind or connect to as far as the kernel's
// Landlock knows ports. What is not there is left out. Returns Landlock's version; 0: the kernel has none, and the threads are only
// kept from new rights. Throws std::system_error.
int restrict_files(const std::vector<Box::Place>& places);

}  // namespace gicube::emu

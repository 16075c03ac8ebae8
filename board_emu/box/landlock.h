// Restricts the files and TCP of this process with the kernel's Landlock.
#pragma once

#include <vector>

#include "box.h"

namespace gicube::emu {

// Restricts all threads of the process to these paths. Executing programs is not allowed, nor binding or connecting
// TCP ports if Landlock supports ports. Paths that do not exist are ignored. Returns Landlock's version; 0: the kernel
// has none, and the threads only cannot gain privileges. Throws std::system_error.
int restrict_files(const std::vector<Box::Path>& paths);

}  // namespace gicube::emu

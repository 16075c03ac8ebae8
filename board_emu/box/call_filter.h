// Restricts the system calls of this process with seccomp.
#pragma once

namespace gicube::emu {

// Applies to all threads of the process. `uses_files`: opens, renames and removes files. `has_clients`: accepts
// connections. Returns false if the kernel has no such filters. Throws std::system_error.
bool filter_calls(bool uses_files, bool has_clients);

}  // namespace gicube::emu

// The system calls that this process may make, by seccomp.
#pragma once

namespace gicube::emu {

// For every thread of the process. `uses_files`: opens, renames and removes files; `has_clients`: takes connections. False: the kernel has
// no such filters. Throws std::system_error.
bool filter_calls(bool uses_files, bool has_clients);

}  // namespace gicube::emu

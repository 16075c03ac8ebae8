// The registry: a folder of each user in which every board process of his has a socket, named by its process id. Whoever connects
// is told a gicube.v1.BoardProcess (management.proto) and then the end of the stream; nothing is read from him. A socket that does
// not answer yet is called ".PID"; one on which nobody listens is left from a process that was killed.
#pragma once

#include <string>

namespace gicube {

// The folder "gicube" in $XDG_RUNTIME_DIR, if that is a folder of this process's user; otherwise /tmp/gicube-UID; if
// another user has taken that name, .gicube-HOST in $HOME. HOST is this machine, since others may have the same home.
std::string registry_folder();

// Why this folder can't be trusted, as "expected ..., got ...": it must be this user's, and closed to all others. Empty: it can be.
std::string registry_fault(const std::string& folder);

// Removes the sockets that killed processes have left in this folder: those on which nobody listens, and whose process is no more.
void remove_dead_sockets(const std::string& folder);

}  // namespace gicube

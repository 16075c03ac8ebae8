// The registry: one folder per user, with one socket per board process, named after its process id. A client that
// connects receives a gicube.v1.BoardProcess (management.proto), then the end of the stream; the process reads nothing.
// A socket that does not answer yet is called ".PID". A socket without a listener is left over from a killed process.
#pragma once

#include <string>

namespace gicube {

// Returns the path of the registry. It is $XDG_RUNTIME_DIR/gicube if that variable names a folder of this process's
// user, otherwise /tmp/gicube-UID. If another user has taken that name, it is $HOME/.gicube-HOST. HOST is this
// machine's name, because several machines may share a home folder.
std::string registry_folder();

// Returns why this folder cannot be trusted, as "expected ..., got ...", or an empty string if it can. It must belong
// to this user and be closed to all others.
std::string registry_fault(const std::string& folder);

// Creates this user's registry if necessary and returns its path. Throws std::runtime_error if it cannot be trusted.
std::string open_registry();

// Returns false if no process listens at this Unix socket. If that cannot be determined, returns true.
bool listens(const std::string& path);

// The permissions of a file's mode as three octal digits.
std::string mode_text(unsigned mode);

// Removes sockets that killed processes have left in this folder. They have no listener, and their process does not
// exist.
void remove_dead_sockets(const std::string& folder);

}  // namespace gicube

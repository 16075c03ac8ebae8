// The sandbox ("box") that a board process enters when it has opened all that it needs. After that, its threads may
// only make the system calls that a running board needs. If an attacker gets code into the process, through a
// vulnerability of the board or of a library or as a scattering routine, this code cannot read files, start programs,
// or reach other processes or machines. docs/reference/security.md lists what is allowed.
//
// It has two parts, each used if the kernel supports it: Landlock for files and TCP, and a system call filter
// (seccomp).
#pragma once

#include <string>
#include <vector>

namespace gicube::emu {

struct Box {
  enum class Access {
    kRead,    // read a file, or the files of a folder
    kRemove,  // remove files of a folder
    kWrite,   // create, write, rename and remove files of a folder
  };
  // A folder includes everything below it.
  struct Path {
    std::string path;
    Access access = Access::kRead;
  };
  std::vector<Path> paths{};  // files that may still be used; empty: no file can be opened, renamed or removed
  bool has_clients = true;    // accepts new connections at listening sockets
};

// The parts of the box that are in force.
struct Boxed {
  enum class Part { kMissing, kFailed, kInForce };
  Part files = Part::kMissing, calls = Part::kMissing;
  std::string text;  // description for the log
};

// Applies to all current and future threads and cannot be undone. Open files stay open. In any case the process gains
// no privileges from programs that it executes. With sanitizers there is no box, because they need refused system
// calls.
Boxed enter_box(const Box& box);

}  // namespace gicube::emu

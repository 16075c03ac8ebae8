// The box that a board process puts itself into once it has all that it needs. From then on its threads may ask of the kernel
// what a running board asks, and no more: whoever gets code into the process, by a fault of ours or of a library or as a scattering
// routine, reads no file, starts no program and reaches no other process or machine. docs/reference/security.md lists what is allowed.
//
// Two parts, each where the kernel has it: Landlock for files and TCP, and a filter of system calls (seccomp).
#pragma once

#include <string>
#include <vector>

namespace gicube::emu {

struct Box {
  enum class Access {
    kRead,    // a file, or the files of a folder
    kRemove,  // files of a folder
    kWrite,   // make, write, rename and remove files of a folder
  };
  // A folder stands for all that is below it.
  struct Place {
    std::string path;
    Access access = Access::kRead;
  };
  std::vector<Place> places{};  // that may still be used; none: no file is opened, renamed or removed any more
  bool has_clients = true;      // takes new connections at the sockets that listen
};

// What of a box is in force.
struct Boxed {
  enum class Part { kMissing, kFailed, kInForce };
  Part files = Part::kMissing, calls = Part::kMissing;
  std::string text;  // says so, for the log
};

// For good, and for all threads: those that run and those that they will start. What is open stays open. Whatever comes of it, the process
// gains no rights by what it executes. With sanitizers there is no box: they look at the process in ways that it refuses.
Boxed enter_box(const Box& box);

}  // namespace gicube::emu

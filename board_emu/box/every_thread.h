// Makes system calls that apply to one thread on all threads of the process.
#pragma once

namespace gicube::emu {

// Makes the call on every thread: on other threads in a handler of the signal SIGRTMIN + 5, on the caller last. Threads
// that start meanwhile are included. `call` returns 0 or an errno, and must be async-signal-safe. Not thread-safe.
// Throws std::system_error if a call failed or a thread did not answer within five seconds; the other threads have then
// made the call.
void on_every_thread(int (*call)(int), int argument);

}  // namespace gicube::emu

// Calls that the kernel takes for one thread only, made for the whole process.
#pragma once

namespace gicube::emu {

// Makes the call on every thread: on those of others in a handler of the signal SIGRTMIN + 5, on the caller's last. A thread that
// starts meanwhile is found too. What is called returns 0 or an errno, and must be fit for a signal handler. Not for several threads at
// once. Throws std::system_error: a call failed, or a thread did not answer within five seconds; the other threads have made it.
void on_every_thread(int (*call)(int), int argument);

}  // namespace gicube::emu

// Runs code of others that may never return, on the calling thread.
//
// A timer of the thread ticks in real time; a call that the ticks find still running after it has used kCpuLimit of the
// thread's processor time, or after kTicksLimit ticks (for one that sleeps), is left by a jump out of the tick's signal
// handler. What it held then stays held: its memory, its locks, its C++ objects. A call that returns is not touched, so
// no result depends on the clock. Signal: SIGRTMIN + 4.
#pragma once

#include <chrono>
#include <type_traits>

namespace gicube::emu {

inline constexpr std::chrono::milliseconds kTick{250};
inline constexpr std::chrono::milliseconds kCpuLimit{1000};  // chosen: a thousand times what any routine should take
inline constexpr int kTicksLimit = 120;  // chosen: 30 s, in which a loaded machine gets its second done

// False if the call was left. What the call throws goes through. Calls must not nest. Throws std::system_error if the
// thread can't have a timer.
bool run_limited(void (*call)(void*), void* context);

// The same for any callable without arguments.
template <typename Call>
bool run_limited(Call&& call) {
  return run_limited([](void* context) { (*static_cast<std::remove_reference_t<Call>*>(context))(); }, &call);
}

}  // namespace gicube::emu

// The separate process, gicube-plug-in-host, in which the code of a plug-in runs: a scattering routine or an observer.
// It shares only a socket and the memory of the calls with the board process; an observer also has its environment and
// standard error.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "plug_ins/call_memory.h"

namespace gicube::emu {

inline constexpr std::chrono::milliseconds kTick{250};
inline constexpr std::chrono::milliseconds kCpuLimit{1000};  // chosen: a thousand times the longest sensible call
inline constexpr int kTicksLimit = 120;  // chosen: enough for a second of processor time on a loaded machine

// The shared object cannot be used. The text names the file and the reason.
struct PlugInFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class PlugInProcess {
 public:
  static constexpr std::chrono::milliseconds kPatience = kTicksLimit * kTick;  // 30 s, for an observer
  static constexpr std::chrono::milliseconds kRoutinePatience{5000};  // chosen: a thousand times a process's end

  enum class Kind { kRoutine, kObserver };
  enum class Waited { kAnswered, kEnded, kStuck, kLost };

  // Starts the process, which loads `file`. `is_boxed`: the code then runs in the box (box/box.h). The process itself
  // forks the processes for a routine's calls. Throws PlugInFault.
  PlugInProcess(Kind kind, const std::string& file, bool is_boxed);
  // Waits until the process has received everything that was sent and has ended. After kPatience or kRoutinePatience,
  // kills it.
  ~PlugInProcess();
  PlugInProcess(const PlugInProcess&) = delete;
  PlugInProcess& operator=(const PlugInProcess&) = delete;

  CallMemory& memory() const { return *memory_; }

  // Returns false if the process has ended, or does not take the message in time.
  bool send(const void* message, std::size_t bytes, std::chrono::milliseconds patience = {}) const;
  bool has_gone() const;
  // Makes the destructor kill the process without waiting.
  void give_up() { memory_->loading.turn.give(Party::kNobody); }

  // Waits while it is the plug-in's turn. kStuck: `process` (0: none) has used kCpuLimit of processor time, or
  // kTicksLimit ticks have passed. Both limits start again for each of the `steps`. A call that returns is never
  // aborted, so no result depends on the clock.
  Waited wait(Turn& turn, const std::int32_t& process, unsigned max_spins, Patience& patience,
              std::uint32_t steps = 1) const;

 private:
  void load(Kind kind, const std::string& file, bool is_boxed);
  void stop();

  CallMemory* memory_ = nullptr;
  pid_t process_ = 0;
  int socket_ = -1;
  const std::chrono::milliseconds patience_;  // how long the destructor waits
};

// States how a process ended, from its status of waitpid() or CallSlot::kNoProcess.
std::string end_of(int status);
// States that kCpuLimit was exceeded.
std::string stuck();
// Returns at most `max_length` bytes of the text, with '?' for unprintable ones.
std::string printable(const char* text, std::size_t max_length);

}  // namespace gicube::emu

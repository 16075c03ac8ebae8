// The process of its own in which the code of a plug-in runs, a scattering routine or an observer: gicube-plug-in-host.
// It has nothing of the board's process but a socket and the memory of the calls; an observer has its environment and
// standard error too.
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
inline constexpr std::chrono::milliseconds kCpuLimit{1000};  // chosen: a thousand times what any routine should take
inline constexpr int kTicksLimit = 120;                      // chosen: a loaded machine gets its second done by then

// The object can't be used; the text names the file and says why.
struct PlugInFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class PlugInProcess {
 public:
  static constexpr std::chrono::milliseconds kPatience = kTicksLimit * kTick;  // 30 s, for an observer
  static constexpr std::chrono::milliseconds kRoutinePatience{5000};  // chosen: a thousand times the end of a process

  enum class Kind { kRoutine, kObserver };
  enum class Waited { kAnswered, kEnded, kStuck, kLost };

  // Starts it and has it load `file`; `is_boxed`: the code then runs in a box (box/box.h). The process makes the copies
  // for a routine's calls, so the board's process starts no other. Throws PlugInFault.
  PlugInProcess(Kind kind, const std::string& file, bool is_boxed);
  // The process has had all that was sent, and has ended, or was ended after kPatience or kRoutinePatience.
  ~PlugInProcess();
  PlugInProcess(const PlugInProcess&) = delete;
  PlugInProcess& operator=(const PlugInProcess&) = delete;

  CallMemory& memory() const { return *memory_; }

  // False if it is gone, or does not take the message in time.
  bool send(const void* message, std::size_t bytes, std::chrono::milliseconds patience = {}) const;
  bool has_gone() const;
  // The destructor does not wait for it.
  void give_up() { memory_->loading.turn.give(Party::kNobody); }

  // Until the turn is not the plug-in's. kStuck: `process` (0: none) has used kCpuLimit of processor time, or has taken
  // kTicksLimit ticks (if it sleeps); for each of the `steps` both begin anew. A call that returns is not touched, so
  // no result depends on the clock.
  Waited wait(Turn& turn, const std::int32_t& process, unsigned max_spins, Patience& patience,
              std::uint32_t steps = 1) const;

 private:
  void load(Kind kind, const std::string& file, bool is_boxed);
  void stop();

  CallMemory* memory_ = nullptr;
  pid_t process_ = 0;
  int socket_ = -1;
  const std::chrono::milliseconds patience_;  // for its end
};

// How a process ended, by what waitpid() says or CallSlot::kNoProcess.
std::string end_of(int status);
// Says that kCpuLimit is over.
std::string stuck();
// At most `max_length` bytes of it, as others may see them.
std::string printable(const char* text, std::size_t max_length);

}  // namespace gicube::emu

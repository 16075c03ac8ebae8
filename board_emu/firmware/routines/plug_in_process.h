// The process of its own in which the code of a plug-in runs: gicube-bsdf-host, with a copy of itself for each call at a time.
//
// It has nothing of the board's process but the memory of the calls. Whatever its code does, the board gets an answer, or a fault
// once a call has used kCpuLimit of processor time, or taken kTicksLimit ticks (if it sleeps). A call that returns is not touched, so no
// result depends on the clock.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "datapath/scattering.h"
#include "firmware/routines/call_memory.h"

namespace gicube::emu {

inline constexpr std::chrono::milliseconds kTick{250};
inline constexpr std::chrono::milliseconds kCpuLimit{1000};  // chosen: a thousand times what any routine should take
inline constexpr int kTicksLimit = 120;  // chosen: 30 s, in which a loaded machine gets its second done

// The object can't be used; the text names the file and says why.
struct PlugInFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class PlugInProcess {
 public:
  // Starts it and has it load `file`; `is_boxed`: calls are made in a box (box/box.h). All later processes are copies of it: the board's process starts none any more. Throws
  // PlugInFault.
  explicit PlugInProcess(const std::string& file, bool is_boxed = true);
  // The process has ended then.
  ~PlugInProcess();
  PlugInProcess(const PlugInProcess&) = delete;
  PlugInProcess& operator=(const PlugInProcess&) = delete;

  const RoutineDescription& description() const { return description_; }

  // From several threads. Return what went wrong, if anything did. The process that ended or had to be ended is begun anew by the
  // next call. At most kMaxEvents events, each with at most kMaxParameters parameters, and as many answers.
  std::optional<std::string> scatter(std::span<const ScatterEvent> events, std::span<ScatterAnswer> answers);
  // `text`: receives what the check says.
  std::optional<std::string> check(std::span<const float> parameters, int& verdict, std::string& text);

 private:
  class Claim;

  enum class Waited { kAnswered, kEnded, kStuck, kLost };

  void load(const std::string& file, bool is_boxed);
  void stop();
  bool has_gone() const;
  bool order(SlotOrder::Kind kind, std::size_t slot) const;
  // `steps`: in which the other side may take its time anew.
  Waited wait(Turn& turn, const std::int32_t& process, unsigned max_spins, Patience& patience,
              std::uint32_t steps = 1) const;
  std::optional<std::string> call(Claim& claim, std::uint32_t count);

  CallMemory* memory_ = nullptr;
  RoutineDescription description_;
  pid_t process_ = 0;
  int orders_ = -1;

  std::atomic<unsigned> at_once_{0};  // calls that there were at once, at most

  struct alignas(64) SlotState {
    std::atomic<bool> is_taken{false};
    Patience patience{};
  };
  std::unique_ptr<SlotState[]> slot_states_ = std::make_unique<SlotState[]>(kMaxCalls);
};

// At most `max_length` bytes of it, as others may see them.
std::string printable(const char* text, std::size_t max_length);

}  // namespace gicube::emu

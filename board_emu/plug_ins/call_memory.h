// The memory that a board process shares with the process of a plug-in: the result of loading the plug-in, and slots
// for calls of a routine. A slot holds one call at a time, with one or more events. Orders to a routine's process and
// events for an observer go through a socket.
//
// The plug-in's code can write this memory at any time. Readers must copy a value before they check it, and must not
// trust it.
#pragma once

#include <linux/futex.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "gicube/bsdf.h"

namespace gicube::emu {

inline constexpr std::size_t kMaxCalls = 256;      // chosen: concurrent calls; further threads wait
inline constexpr std::size_t kMaxEvents = 64;      // chosen: per call; as many as the functional level has in a thread
inline constexpr std::size_t kMaxParameters = 32;  // gicube_bsdf_event
inline constexpr std::size_t kMaxObserved = 256;   // chosen: events per message to an observer, about 40 KB
inline constexpr std::size_t kMaxName = 64;
inline constexpr std::size_t kMaxText = 512;
inline constexpr std::size_t kPage = 4096;

enum class Party : std::uint32_t {
  kNobody,  // no process serves the slot
  kBoard,
  kPlugIn,
};

// Decides how one side waits for the other: it polls for a while, then sleeps. If polling was in vain, as on a busy
// machine, the next waits sleep at once.
class Patience {
 public:
  // How often to poll in this wait.
  unsigned spins(unsigned at_most) {
    if (sleeps_ == 0) return at_most;
    --sleeps_;
    return 0;
  }
  void was_in_vain() { sleeps_ = kSleeps; }

 private:
  static constexpr unsigned kSleeps = 15;  // chosen: polling in vain then costs a tenth as much as sleeping
  unsigned sleeps_ = 0;
};

// States which side may read and write the data beside it, and lets the other side wait.
class Turn {
 public:
  Party now() const { return party_.load(std::memory_order_acquire); }

  void give(Party to) {
    party_.store(to);
    wake(to);
  }
  // Returns false, and changes nothing, if it is not the turn of `from`.
  bool give(Party from, Party to) {
    if (!party_.compare_exchange_strong(from, to)) return false;
    wake(to);
    return true;
  }

  // To be called by a new process of the plug-in, because the previous one may have ended while it slept.
  void begin() { plug_in_sleeps_ = 0; }

  // Counts the finished steps of all turns. The plug-in's side calls step().
  void step() { steps_.store(steps_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed); }
  std::uint32_t steps() const { return steps_.load(std::memory_order_relaxed); }

  // Waits while it is the turn of `other`. Returns false if it still is, after `limit` or a signal.
  bool wait_for(Party other, unsigned max_spins, Patience& patience, std::chrono::milliseconds limit) {
    const unsigned spins = patience.spins(max_spins);
    for (unsigned i = 0; i < spins; ++i) {
      if (now() != other) return true;
      relax();
    }
    if (spins > 0) patience.was_in_vain();
    std::atomic<std::uint32_t>& asleep = other == Party::kPlugIn ? board_sleeps_ : plug_in_sleeps_;
    asleep = 1;
    if (party_ == other) {
      const timespec time{limit.count() / 1000, limit.count() % 1000 * 1'000'000};
      ::syscall(SYS_futex, &party_, FUTEX_WAIT, static_cast<std::uint32_t>(other), &time, nullptr, 0);
    }
    asleep = 0;
    return now() != other;
  }

 private:
  static void relax() {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("isb");
#endif
  }
  void wake(Party to) {
    if ((to == Party::kPlugIn ? plug_in_sleeps_ : board_sleeps_) == 0) return;
    ::syscall(SYS_futex, &party_, FUTEX_WAKE, 1, nullptr, nullptr, 0);
  }

  std::atomic<Party> party_{Party::kNobody};
  std::atomic<std::uint32_t> board_sleeps_{0}, plug_in_sleeps_{0}, steps_{0};
};
static_assert(std::atomic<Party>::is_always_lock_free && sizeof(std::atomic<Party>) == sizeof(std::uint32_t));

// The fields of a gicube_bsdf that are not addresses.
struct RoutineDescription {
  std::uint32_t abi = 0;
  std::uint32_t size = 0;  // the other fields are set only if these two match the board's
  char name[kMaxName + 1] = {};
  std::uint32_t cycles = 0;
  std::uint32_t cycle_budget = 0;
  std::uint32_t has_scatter = 0;
  std::uint32_t has_check = 0;
};

// The result of loading, written by the plug-in's process.
struct Loading {
  Turn turn;                  // kBoard: loading has ended
  char fault[kMaxText] = {};  // empty: the description is valid
  RoutineDescription description;
};

enum class CallKind : std::uint32_t { kScatter, kCheck };

struct alignas(kPage) CallSlot {
  Turn turn;
  CallKind call = CallKind::kScatter;
  std::uint32_t has_thrown = 0;
  std::uint32_t spins = 0;   // how often the plug-in's side polls for the next call before it sleeps
  std::int32_t verdict = 0;  // result of a check
  std::uint32_t count = 0;   // number of events
  struct Event {
    gicube_bsdf_event event{};  // its pointer to the parameters is not set
    float parameters[kMaxParameters] = {};
  };
  gicube_bsdf_answer answers[kMaxEvents] = {};
  alignas(64) Event events[kMaxEvents] = {};      // a check uses the parameters of the first
  char text[kMaxText] = {};                       // reason of a failed check, or text of an exception
  std::int32_t process = 0;                       // the process that serves the slot
  std::int32_t wait_status = 0;                   // status of its end (waitpid), or kNoProcess
  static constexpr std::int32_t kNoProcess = -1;  // no process could be started
};

struct CallMemory {
  alignas(kPage) Loading loading;
  CallSlot slots[kMaxCalls];
};

// An order to a routine's process: start or end the process that serves a slot.
struct SlotOrder {
  enum class Kind : std::uint32_t { kBegin, kEnd };
  Kind kind = Kind::kBegin;
  std::uint32_t slot = 0;
};

// The arguments of that process after the library: its kind, and whether its code runs in the box once it is loaded.
inline constexpr const char *kRoutineWord = "routine", *kObserverWord = "observer";
inline constexpr const char *kBoxedWord = "boxed", *kUnboxedWord = "unboxed";

// The descriptors that the plug-in's process inherits, in addition to the first three.
inline constexpr int kSocketDescriptor = 3, kMemoryDescriptor = 4;

}  // namespace gicube::emu

// The memory that a board's process shares with the process of a plug-in: how its start went, and the calls of a
// routine, one at a time in each slot, of one event or many, and whose turn it is. Orders to a routine's process and
// the events of an observer go through a socket.
//
// Whoever reads here what the other one wrote takes a copy first, and believes nothing of it: code of others can write
// it at any time.
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

inline constexpr std::size_t kMaxCalls = 256;  // chosen: at once; threads that find no slot wait for one
inline constexpr std::size_t kMaxEvents = 64;  // chosen: of a call; what the functional level has under way in a thread
inline constexpr std::size_t kMaxParameters = 32;  // gicube_bsdf_event
inline constexpr std::size_t kMaxObserved = 256;   // chosen: events that an observer gets at once, some ten kilobytes
inline constexpr std::size_t kMaxName = 64;
inline constexpr std::size_t kMaxText = 512;
inline constexpr std::size_t kPage = 4096;

enum class Party : std::uint32_t {
  kNobody,  // no process serves the slot
  kBoard,
  kPlugIn,
};

// How a side waits: it looks for the other's word for a while, and then sleeps. After it has looked in vain, as on a
// machine that is busy with something else, it sleeps at once the next times.
class Patience {
 public:
  // How often to look now.
  unsigned spins(unsigned at_most) {
    if (sleeps_ == 0) return at_most;
    --sleeps_;
    return 0;
  }
  void was_in_vain() { sleeps_ = kSleeps; }

 private:
  static constexpr unsigned kSleeps = 15;  // chosen: looking in vain then costs a tenth of what sleeping does
  unsigned sleeps_ = 0;
};

// Who may read and write what stands beside it.
class Turn {
 public:
  Party now() const { return party_.load(std::memory_order_acquire); }

  void give(Party to) {
    party_.store(to);
    wake(to);
  }
  // False, and nothing is done, if it is not `from`'s.
  bool give(Party from, Party to) {
    if (!party_.compare_exchange_strong(from, to)) return false;
    wake(to);
    return true;
  }

  // Called for a new process: the previous one may have ended while it slept.
  void begin() { plug_in_sleeps_ = 0; }

  // How much has been done in all turns, as the plug-in's side says.
  void step() { steps_.store(steps_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed); }
  std::uint32_t steps() const { return steps_.load(std::memory_order_relaxed); }

  // Until it is not `other`'s any more. False: it still is, after `limit` or a signal.
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
  std::uint32_t size = 0;  // the rest is only there if these two are the board's
  char name[kMaxName + 1] = {};
  std::uint32_t cycles = 0;
  std::uint32_t cycle_budget = 0;
  std::uint32_t has_scatter = 0;
  std::uint32_t has_check = 0;
};

// The plug-in's process says here how its start went.
struct Loading {
  Turn turn;                  // the board's: it is done
  char fault[kMaxText] = {};  // empty: the description holds
  RoutineDescription description;
};

enum class CallKind : std::uint32_t { kScatter, kCheck };

struct alignas(kPage) CallSlot {
  Turn turn;
  CallKind call = CallKind::kScatter;
  std::uint32_t has_thrown = 0;
  std::uint32_t spins = 0;   // how often the plug-in's side looks for the next call before it sleeps
  std::int32_t verdict = 0;  // of a check
  std::uint32_t count = 0;   // of the events
  struct Event {
    gicube_bsdf_event event{};  // without the parameters' address
    float parameters[kMaxParameters] = {};
  };
  gicube_bsdf_answer answers[kMaxEvents] = {};
  alignas(64) Event events[kMaxEvents] = {};      // a check has the parameters of the first
  char text[kMaxText] = {};                       // of a check that refuses, or of an exception
  std::int32_t process = 0;                       // that serves the slot
  std::int32_t wait_status = 0;                   // of its end (waitpid), or:
  static constexpr std::int32_t kNoProcess = -1;  // none could be started
};

struct CallMemory {
  alignas(kPage) Loading loading;
  CallSlot slots[kMaxCalls];
};

// An order to a routine's process: a process for a slot, or an end to one.
struct SlotOrder {
  enum class Kind : std::uint32_t { kBegin, kEnd };
  Kind kind = Kind::kBegin;
  std::uint32_t slot = 0;
};

// The arguments of that process after the library: what it is; whether its code runs in a box once it is loaded.
inline constexpr const char *kRoutineWord = "routine", *kObserverWord = "observer";
inline constexpr const char *kBoxedWord = "boxed", *kUnboxedWord = "unboxed";

// The descriptors that the plug-in's process is started with, beside the first three.
inline constexpr int kSocketDescriptor = 3, kMemoryDescriptor = 4;

}  // namespace gicube::emu

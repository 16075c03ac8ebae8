// Stops a board's machine at conditions, and looks into it while it stands; for one client at a time.
//
// The thread of the board's command waits in a callback meanwhile, and the client's thread looks at the machine only while it does, under
// the same lock; so nothing is read as it changes. Simulated time does not depend on it, unless the client sets a word. A board that
// stands goes on when the client leaves, after `max_stand` without a word from him, and when its session is to end.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "observe/breakpoints.h"

namespace gicube::emu {

class Debugger : public Observer {
 public:
  static constexpr std::chrono::minutes kMaxPause{10};     // chosen: long enough to think
  static constexpr std::chrono::seconds kMaxContinue{60};  // chosen: `continue` answers by then, whatever comes

  struct Answer {
    std::string text;
    bool is_fault = false;
    bool is_paused = false;  // the board
  };
  using Cancelled = std::function<bool()>;

  explicit Debugger(std::chrono::milliseconds max_pause = kMaxPause) : max_pause_(max_pause) {}

  // A client comes; false if there is one. From the next command on, or within 4096 cycles, the machine is looked at.
  bool attach();
  // He has left: nothing stops any more.
  void detach();
  // A line of his. Returns when it is carried out, for `continue` and `step` when the board stands again, or `cancelled` is true.
  Answer carry_out(const std::string& line, const Cancelled& cancelled);
  // The board goes on, and stops no more until the next line that wants it to: its session is to end. Any thread.
  void let_go();
  // Calls `job` once on the command's thread where the board stands, at the end of the cycle in which it does; the board stands on. It
  // must not throw. False if it does not stand. If it is told to go on before, the job is dropped. Any thread.
  bool offer(std::function<void()> job);
  bool is_paused() const {
    const std::lock_guard lock(mutex_);
    return is_paused_;
  }
  bool is_attached() const { return is_attached_.load(std::memory_order_relaxed); }

  // On the command's thread: `begin` as BoardObserver's.
  void power_up(std::uint64_t core_khz, bool has_cycles);
  void begin_command(Picoseconds begin, std::uint32_t ticket);
  void counted(const std::vector<wire::Counter>& counters);

  bool is_interested() const override { return is_attached(); }
  void begins(Cycle now, Machine& machine) override;
  Cycle next(Cycle from) override;
  void see(Cycle now, const Machine& machine) override;
  bool watches(std::uint64_t ray, const wire::Ray& made) override;
  void happened(const RayEvent& event, const Machine& machine) override;

 private:
  using Lock = std::unique_lock<std::mutex>;
  using Words = std::vector<std::string>;

  struct History {
    std::deque<std::string> lines;
    std::uint32_t handle = 0;
    bool is_under_way = false;
  };

  // Whether jobs can be done where the board stands, or not before the end of the cycle.
  enum class Moment : std::uint8_t { kInCycle, kEndOfCycle };

  void pause(Lock& lock, Cycle now, const std::string& why, Moment moment = Moment::kEndOfCycle);
  void wait_while_paused(Lock& lock, Moment moment);
  std::string wait_for_stop(Lock& lock, std::uint64_t before, std::chrono::seconds limit, const Cancelled& cancelled);
  std::string where();
  std::string go(const Words& words, Lock& lock, const Cancelled& cancelled);
  std::string answer(const Words& words, Lock& lock, const Cancelled& cancelled);
  std::string answer_paused(const Words& words);
  const History& history_of(const Words& words, std::size_t at) const;
  void add(Breakpoint breakpoint);

  const std::chrono::milliseconds max_pause_;
  std::atomic<bool> is_attached_ = false;
  mutable std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  bool has_cycles_ = false;
  bool is_paused_ = false;
  bool goes_ = false;                 // it is told to go on
  bool is_let_go_ = false;            // nothing stops the command any more
  bool stops_soon_ = false;           // at the next occasion
  bool pauses_at_cycle_end_ = false;  // at the end of the cycle, for job_
  std::function<void()> job_;
  bool stops_at_command_ = false;  // that is the next command
  std::optional<Breakpoint> step_;
  std::vector<Breakpoint> breakpoints_;
  std::vector<Breakpoint> watched_;  // rays whose history is kept
  unsigned last_number_ = 0;
  std::string why_;  // it stands
  std::uint64_t stops_ = 0;
  std::uint64_t reported_stops_ = 0;  // of which the client has been told
  std::uint64_t commands_ = 0;        // that have begun since power-up
  std::uint32_t ticket_ = 0;          // of the latest
  CommandClock clock_;
  bool is_first_run_ = false;  // of the command
  Cycle now_ = 0;
  Machine* machine_ = nullptr;  // of the run; looked at only while it stands
  std::map<std::uint64_t, History> histories_;
  std::chrono::steady_clock::time_point last_activity_;
};

}  // namespace gicube::emu

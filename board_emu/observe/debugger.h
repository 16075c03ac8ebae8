// Pauses a board's machine at breakpoints, and inspects it while it is paused. It serves one client at a time.
//
// While the board is paused, the thread of its command waits in a callback. The client's thread reads the machine only
// then and under the same lock, so it never reads changing data. Simulated time does not depend on the debugger, unless
// the client sets a word. A paused board resumes when the client leaves, after `max_pause` without a line from the
// client, and when its session is to end.
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
  static constexpr std::chrono::seconds kMaxContinue{60};  // chosen: `continue` replies by then in any case

  struct Answer {
    std::string text;
    bool is_fault = false;
    bool is_paused = false;  // the board is paused
  };
  using Cancelled = std::function<bool()>;

  explicit Debugger(std::chrono::milliseconds max_pause = kMaxPause) : max_pause_(max_pause) {}

  // Attaches a client. Returns false if another one is attached. The machine is observed from the next command on, or
  // within 4096 cycles.
  bool attach();
  // Detaches the client, removes its breakpoints and resumes the board.
  void detach();
  // Executes a line of the client. `continue`, `step` and `stop` wait until the board is paused, their time limit has
  // passed or `cancelled` returns true.
  Answer carry_out(const std::string& line, const Cancelled& cancelled);
  // Resumes the board, because its session is to end. Cancels steps and stops; nothing pauses the rest of the command.
  // Any thread.
  void let_go();
  // Calls `job` once on the command's thread, at the end of the cycle in which the board is paused; the board stays
  // paused. `job` must not throw. It is dropped if the board is resumed before. Returns false if the board is not
  // paused. Any thread.
  bool offer(std::function<void()> job);
  bool is_paused() const {
    const std::lock_guard lock(mutex_);
    return is_paused_;
  }
  bool is_attached() const { return is_attached_.load(std::memory_order_relaxed); }

  // Called on the command's thread. `begin`: as in BoardObserver.
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

  // When the board is paused: jobs can be executed at once only at the end of a cycle.
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
  mutable std::mutex mutex_;  // guards all members below
  std::condition_variable changed_;
  bool has_cycles_ = false;
  bool is_paused_ = false;
  bool goes_ = false;                 // it has been resumed
  bool is_let_go_ = false;            // nothing pauses the rest of the command
  bool stops_soon_ = false;           // at the next cycle, or command if there are no cycles
  bool pauses_at_cycle_end_ = false;  // to execute job_
  std::function<void()> job_;
  bool stops_at_command_ = false;  // the next one
  std::optional<Breakpoint> step_;
  std::vector<Breakpoint> breakpoints_;
  std::vector<Breakpoint> watched_;  // rays whose history is kept
  unsigned last_number_ = 0;
  std::string why_;  // reason of the latest stop
  std::uint64_t stops_ = 0;
  std::uint64_t reported_stops_ = 0;  // those that the client knows of
  std::uint64_t commands_ = 0;        // begun since power-up
  std::uint32_t ticket_ = 0;          // of the latest command
  CommandClock clock_;
  bool is_first_run_ = false;  // the command's first run has not begun
  Cycle now_ = 0;
  Machine* machine_ = nullptr;  // of the present run; read only while it is paused
  std::map<std::uint64_t, History> histories_;
  std::chrono::steady_clock::time_point last_activity_;
};

}  // namespace gicube::emu

// One board of this process with its configuration and its owner: what the bus server and the management plane share.
//
// A board has at most one owner, either a session or the management plane while it resets or rebuilds the board. Only
// the owner touches the board's state; counters can be read at any time. Who wants a board that has an owner stands in
// line. An owner whose client is away makes way for the first in line. All calls from any thread.
//
// Each owner has a new board: the last one's is gone, with its memory, before the next is built. If that fails the slot has no
// board, and the next owner's first act is to try again.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/thread_pool.hpp>

#include "board/board.h"
#include "board/checkpoint.h"
#include "config/config.h"
#include "firmware/routines/routine_table.h"
#include "observe/observation.h"
#include "server/faults/fault_point.h"

namespace gicube::emu {

// kSoonFree: the owner is about to let go. kForced: the same, and it was made to just now.
enum class Claim { kGranted, kBusy, kSoonFree, kForced };

// Asked now and then by calls that may take a while. True: nobody waits for their answer any more.
using Cancelled = std::function<bool()>;

// Asks a session to end, with what its client is told. Must not block.
using EndSession = std::function<void(wire::ErrorCode error, std::string text)>;

struct Claimant {
  EndSession end_session{};  // called at most once, from any thread
  std::string name{};        // as others are told who owns the board
  std::uint64_t place = 0;   // in line; 0 = beside it, which is only good if nobody stands there
  bool force = false;        // take the board from its owner
};

// What a checkpoint of a served board has beside the board.
struct SavedSurroundings {
  SavedFaults faults{};
  // What the driver itself must remember of its board (driver/src/board/saved_state.cpp); empty: nothing.
  std::vector<std::uint8_t> driver{};

  void state(Archive& archive) {
    archive("faults", faults);
    archive.bytes("driver", driver, 0, ~std::uint64_t{0});
  }
};

class BoardSlot {
 public:
  // `config` must be checked; it is resolved here. `observation`: of this board alone. Throws as Observation's constructor. `start`: what
  // each new board is at its power-up, which `config` must fit (fork_faults()); null: nothing. The rest: as Board's. Throws
  // CheckpointFault.
  BoardSlot(std::uint32_t index, const v1::BoardConfig& config, const ObservationOptions& observation = {},
            const RoutineTable* routines = nullptr, std::uint64_t max_memory_bytes = kUnlimitedMemory,
            std::shared_ptr<const Checkpoint> start = nullptr);
  virtual ~BoardSlot();

  BoardSlot(const BoardSlot&) = delete;
  BoardSlot& operator=(const BoardSlot&) = delete;

  std::uint32_t index() const { return index_; }

  // A place in line, at its end or at its head; it must be left again.
  std::uint64_t stand_in_line(bool at_head) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t place = ++last_place_;
    line_.insert(at_head ? line_.begin() : line_.end(), place);
    return place;
  }
  void leave_line(std::uint64_t place) {
    const std::lock_guard lock(mutex_);
    std::erase(line_, place);
  }
  // For a session.
  Claim claim(const Claimant& who);
  // The owner, and since when; empty if there is none.
  std::string owner() const;
  // The session's client is away, or back again. While it is away the board counts as free.
  void set_away(bool away) {
    const std::lock_guard lock(mutex_);
    away_ = away && owner_ == Owner::kSession;
  }
  // The session still owns the board, but will release it as soon as the running work has ended.
  void announce_release() {
    const std::lock_guard lock(mutex_);
    releasing_ = true;
  }
  // What it left on the board must be gone: renew(), drop_board().
  void release() {
    const std::lock_guard lock(mutex_);
    owner_ = Owner::kNone;
    releasing_ = away_ = false;
    held_bytes_ = 0;
    end_session_ = nullptr;
    released_.notify_all();
  }

  // Only for the owner, and only from work on compute().
  Board& board() { return *board_; }
  // Ends the board and builds a new one. If that fails it is logged, `why` says so, and there is none.
  void renew(std::string& why);
  // Only for the owner, from work on compute(): hands out a checkpoint with the driver's part.
  void save(std::vector<std::uint8_t> driver, const std::function<void(std::string_view)>& sink);
  // Only for the owner, from work on compute(): the board goes on from a checkpoint, and so does the fault plan if it is that of the
  // checkpoint. Another plan is taken over if `takes_plan`, or else refused if the checkpoint has one. Returns the driver's part.
  // Throws CheckpointFault, std::bad_alloc: all is as before.
  std::vector<std::uint8_t> restore(const Checkpoint& checkpoint, bool takes_plan);
  // The same with what each new board begins with, which must not be null; `is_new`: it is that board still. Its fault plan counts only
  // if it is in force.
  std::vector<std::uint8_t> restore_start(bool is_new);
  bool has_start() const { return start_ != nullptr; }
  // Only for the owner, while nothing works on compute().
  void drop_board();
  bool has_board() const {
    const std::lock_guard lock(mutex_);
    return board_ != nullptr;
  }
  // The thread on which all of this board's work is done.
  boost::asio::thread_pool& compute() { return compute_; }
  // Returns when all work given to compute() so far has ended. Not from compute() itself.
  void settle();

  void set_endpoint(std::string endpoint) {
    const std::lock_guard lock(mutex_);
    endpoint_ = std::move(endpoint);
  }

  // What a session's client has not fetched, bytes; any thread.
  void set_held(std::uint64_t bytes) { held_bytes_ = bytes; }
  std::uint64_t held_bytes() const { return held_bytes_; }
  // What counts towards the limit of its memory, and the limit; kUnlimitedMemory: none.
  std::uint64_t memory_bytes() const {
    const std::lock_guard lock(mutex_);
    return board_ ? board_->memory_bytes() : 0;
  }
  std::uint64_t max_memory_bytes() const { return max_memory_bytes_; }

  // Answers are held back until the wall clock has come to their simulated time.
  bool realtime() const {
    const std::lock_guard lock(mutex_);
    return config_.pace() == v1::realtime;
  }

  // Of this board; any thread.
  Debugger& debugger() { return debugger_; }

  // What goes wrong between a driver and this board; any thread.
  FaultPoint& faults() { return faults_; }

  struct Info {
    std::uint32_t index = 0;
    std::string endpoint;
    bool in_use = false;
    v1::BoardConfig config;  // resolved
    std::vector<RoutineInfo> routines{};
  };
  Info info() const {
    const std::lock_guard lock(mutex_);
    return {index_, endpoint_, owner_ == Owner::kSession && !away_, config_, routines_->list()};
  }

  Board::Snapshot counters() const {
    const std::lock_guard lock(mutex_);
    return board_ ? board_->snapshot() : Board::Snapshot();
  }

  // The calls of the management plane. On anything but kDone nothing has changed; `reason` says why it is kFaulty or kFailed.
  // kFailed: a board could not be built, as for want of memory.
  enum class Configured { kDone, kInUse, kFaulty, kFailed, kCancelled };
  // Merges configuration text and builds the board anew.
  Configured configure(std::string_view text, std::string& reason, const Cancelled& cancelled = {});

  // The file that the board writes its trace to; empty: none.
  std::string trace_file() const {
    const std::lock_guard lock(mutex_);
    return observation_->options().trace_file;
  }
  // Builds the board anew, to write its trace to a file that is not there yet; empty: to none, and the former file is
  // completed.
  Configured set_trace_file(const std::string& file, std::string& reason, const Cancelled& cancelled = {});

  // Writes a checkpoint to a file that is not there yet, between two transactions of the session: once the command in work is
  // done. `saved`: what it then was.
  struct Saved {
    std::uint64_t simulated_ps = 0, bytes = 0;
  };
  Configured save(const std::string& file, Saved& saved, std::string& reason, const Cancelled& cancelled = {});

  // The power button: ends the owning session and resets the board. kInUse: the session did not end in time. After kInUse and
  // kCancelled it ends all the same, as soon as it can; after kFailed there is no board.
  Configured power_reset(std::string& reason, const Cancelled& cancelled = {});

 protected:
  // Virtual for tests, in which it fails. Throws what there is no memory for.
  virtual std::unique_ptr<Board> build(const v1::BoardConfig& config, Observation* observation) const;

 private:
  enum class Owner { kNone, kSession, kManagement };

  std::unique_ptr<Board> build_from(const Checkpoint* start, const v1::BoardConfig& config,
                                    Observation* observation) const;

  // True once `free()` is, false if that takes too long or nobody waits for it.
  bool wait_until(std::unique_lock<std::mutex>& lock, const Cancelled& cancelled, const std::function<bool()>& free);
  bool take_for_management(std::unique_lock<std::mutex>& lock, const Cancelled& cancelled);
  void log_fault(const Observation* observation) const;
  void ask_to_end(wire::ErrorCode error, const std::string& text);

  const std::uint32_t index_;
  mutable std::mutex mutex_;  // guards everything below but faults_ and compute_
  std::condition_variable released_;
  Owner owner_ = Owner::kNone;
  bool releasing_ = false;
  bool away_ = false;
  std::string owner_name_;
  std::chrono::system_clock::time_point owner_since_;  // as people read it
  std::chrono::steady_clock::time_point owner_began_;  // for how long: the other clock may be set
  std::deque<std::uint64_t> line_;
  std::uint64_t last_place_ = 0;
  std::uint64_t sessions_ = 0;  // so far
  EndSession end_session_;
  std::string endpoint_;
  v1::BoardConfig config_;
  const RoutineTable* const routines_;
  const std::uint64_t max_memory_bytes_;
  const std::shared_ptr<const Checkpoint> start_;
  std::atomic<std::uint64_t> held_bytes_ = 0;
  Debugger debugger_;                         // has a lock of its own
  std::unique_ptr<Observation> observation_;  // only the owner's board speaks to it
  std::unique_ptr<Board> board_;
  std::mutex saving_;  // keeps board_ where it is; taken before mutex_
  FaultPoint faults_;  // has a lock of its own
  boost::asio::thread_pool compute_{1};
};

}  // namespace gicube::emu

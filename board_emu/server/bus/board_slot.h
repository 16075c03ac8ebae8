// One board of this process with its configuration and its owner, shared by the bus server and the management plane.
//
// A board has at most one owner: a session, or the management plane while it resets or rebuilds the board. Only the
// owner accesses the board's state; counters can be read at any time. Clients that request an owned board wait in a
// queue. An owner whose client is away yields the board to the first in the queue. All calls are thread-safe.
//
// Each owner gets a new board. The previous board and its memory are released before the next one is built. If building
// fails, the slot has no board, and the next owner tries again first.
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

// kSoonFree: the owner is about to release the board. kForced: likewise, because this call forced it to.
enum class Claim { kGranted, kBusy, kSoonFree, kForced };

// Polled by calls that may take long. True: the caller no longer waits for the result.
using Cancelled = std::function<bool()>;

// Asks a session to end, with an error and a text for its client. Must not block.
using EndSession = std::function<void(wire::ErrorCode error, std::string text)>;

struct Claimant {
  EndSession end_session{};  // called at most once, from any thread
  std::string name{};        // shown to others as the board's owner
  std::uint64_t place = 0;   // place in the queue; 0 = outside it, which is only valid while the queue is empty
  bool force = false;        // take the board from its owner
};

// State that a checkpoint of a served board contains in addition to the board.
struct SavedSurroundings {
  SavedFaults faults{};
  // The driver's own state of its board (driver/src/board/saved_state.cpp); may be empty.
  std::vector<std::uint8_t> driver{};

  void state(Archive& archive) {
    archive("faults", faults);
    archive.bytes("driver", driver, 0, ~std::uint64_t{0});
  }
};

class BoardSlot {
 public:
  // `config` must be checked; it is resolved here. `observation`: for this board only. `start`: state of each new board
  // at power-up, which must be compatible with `config` (fork_faults()); may be null. Other parameters: see Board.
  // Throws CheckpointFault, and the exceptions of Observation's constructor.
  BoardSlot(std::uint32_t index, const v1::BoardConfig& config, const ObservationOptions& observation = {},
            const RoutineTable* routines = nullptr, std::uint64_t max_memory_bytes = kUnlimitedMemory,
            std::shared_ptr<const Checkpoint> start = nullptr);
  virtual ~BoardSlot();

  BoardSlot(const BoardSlot&) = delete;
  BoardSlot& operator=(const BoardSlot&) = delete;

  std::uint32_t index() const { return index_; }

  // Enters the queue, at its end or at its head. leave_queue() must be called later.
  std::uint64_t enqueue(bool at_head) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t place = ++last_place_;
    queue_.insert(at_head ? queue_.begin() : queue_.end(), place);
    return place;
  }
  void leave_queue(std::uint64_t place) {
    const std::lock_guard lock(mutex_);
    std::erase(queue_, place);
  }
  // Claims the board for a session.
  Claim claim(const Claimant& who);
  // The owner and since when; empty if there is none.
  std::string owner() const;
  // Call when the session's client disconnects or returns. While it is away, the board counts as free.
  void set_away(bool away) {
    const std::lock_guard lock(mutex_);
    away_ = away && owner_ == Owner::kSession;
  }
  // The session still owns the board, but will release it when the running work has ended.
  void announce_release() {
    const std::lock_guard lock(mutex_);
    releasing_ = true;
  }
  // The session's state must have been removed by renew() or drop_board().
  void release() {
    const std::lock_guard lock(mutex_);
    owner_ = Owner::kNone;
    releasing_ = away_ = false;
    held_bytes_ = 0;
    end_session_ = nullptr;
    released_.notify_all();
  }

  // Only for the owner, in jobs of compute().
  Board& board() { return *board_; }
  // Destroys the board and builds a new one. If that fails, the error is logged and returned in `why`, and there is no
  // board.
  void renew(std::string& why);
  // Only for the owner, in jobs of compute(): writes a checkpoint that includes the driver's part.
  void save(std::vector<std::uint8_t> driver, const std::function<void(std::string_view)>& sink);
  // Only for the owner, in jobs of compute(): continues from a checkpoint. The fault plan is also restored if it is the
  // same, or if `takes_plan`; otherwise a checkpoint with another plan is refused. Returns the driver's part. Throws
  // CheckpointFault or std::bad_alloc; nothing has changed then.
  std::vector<std::uint8_t> restore(const Checkpoint& checkpoint, bool takes_plan);
  // Like restore(), from the `start` checkpoint, which must not be null. `is_new`: the board is still in that state.
  // The checkpoint's fault plan is restored only if it is the current one.
  std::vector<std::uint8_t> restore_start(bool is_new);
  bool has_start() const { return start_ != nullptr; }
  // Only for the owner, while compute() is idle.
  void drop_board() { replace(nullptr); }
  bool has_board() const {
    const std::lock_guard lock(mutex_);
    return board_ != nullptr;
  }
  // The thread that executes all work of this board.
  boost::asio::thread_pool& compute() { return compute_; }
  // Waits until all jobs posted to compute() so far have ended. Must not be called on compute().
  void settle();

  void set_endpoint(std::string endpoint) {
    const std::lock_guard lock(mutex_);
    endpoint_ = std::move(endpoint);
  }

  // Bytes of results that the session's client has not fetched. Thread-safe.
  void set_held(std::uint64_t bytes) { held_bytes_ = bytes; }
  std::uint64_t held_bytes() const { return held_bytes_; }
  // Memory that counts towards the limit, and the limit; kUnlimitedMemory: none.
  std::uint64_t memory_bytes() const {
    const std::lock_guard lock(mutex_);
    return board_ ? board_->memory_bytes() : 0;
  }
  std::uint64_t max_memory_bytes() const { return max_memory_bytes_; }

  // Whether answers are delayed until the wall clock has reached their simulated time.
  bool realtime() const {
    const std::lock_guard lock(mutex_);
    return config_.pace() == v1::realtime;
  }

  // Thread-safe.
  Debugger& debugger() { return debugger_; }

  // Fault injection between driver and board. Thread-safe.
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

  // Calls of the management plane. Unless the result is kDone, nothing has changed. `reason` explains kFaulty and
  // kFailed. kFailed: a board could not be built, for example for lack of memory.
  enum class Configured { kDone, kInUse, kFaulty, kFailed, kCancelled };
  // Merges configuration text and rebuilds the board.
  Configured configure(std::string_view text, std::string& reason, const Cancelled& cancelled = {});

  // Trace file of the board; empty: none.
  std::string trace_file() const {
    const std::lock_guard lock(mutex_);
    return observation_->options().trace_file;
  }
  // Rebuilds the board so that it writes its trace to a new file; empty: no trace. The previous file is completed.
  Configured set_trace_file(const std::string& file, std::string& reason, const Cancelled& cancelled = {});

  // Writes a checkpoint to a new file, between two transactions of the session or, on the cycle level, within the
  // current command. `saved`: simulated time and size of the checkpoint.
  struct Saved {
    std::uint64_t simulated_ps = 0, bytes = 0;
  };
  Configured save(const std::string& file, Saved& saved, std::string& reason, const Cancelled& cancelled = {});

  // Power button: ends the owning session and resets the board. kInUse: the session did not end in time. After kInUse
  // and kCancelled the session still ends as soon as possible; after kFailed there is no board.
  Configured power_reset(std::string& reason, const Cancelled& cancelled = {});

 protected:
  // Virtual for tests, where it fails. Throws if there is not enough memory.
  virtual std::unique_ptr<Board> build(const v1::BoardConfig& config, Observation* observation) const;

 private:
  enum class Owner { kNone, kSession, kManagement };

  std::unique_ptr<Board> build_from(const Checkpoint* start, const v1::BoardConfig& config,
                                    Observation* observation) const;

  // Waits for `free()`. Returns false on a timeout or if the caller has cancelled.
  bool wait_until(std::unique_lock<std::mutex>& lock, const Cancelled& cancelled, const std::function<bool()>& free);
  bool take_for_management(std::unique_lock<std::mutex>& lock, const Cancelled& cancelled);
  // Calls `work`, which rebuilds the board, as the owner and without the lock, because building a large board takes a
  // while. Exceptions become kFailed or kFaulty.
  Configured manage(std::unique_lock<std::mutex>& lock, std::string& reason, const Cancelled& cancelled,
                    const std::function<Configured()>& work);
  // The previous board is destroyed without the locks.
  void replace(std::unique_ptr<Board> board) {
    const std::scoped_lock lock(saving_, mutex_);
    board_.swap(board);
  }
  void log_fault(const Observation* observation) const;
  void ask_to_end(wire::ErrorCode error, const std::string& text);

  const std::uint32_t index_;
  mutable std::mutex mutex_;  // guards everything below except faults_ and compute_
  std::condition_variable released_;
  Owner owner_ = Owner::kNone;
  bool releasing_ = false;
  bool away_ = false;
  std::string owner_name_;
  std::chrono::system_clock::time_point owner_since_;  // for display
  std::chrono::steady_clock::time_point owner_began_;  // for durations, because the system clock may be changed
  std::deque<std::uint64_t> queue_;
  std::uint64_t last_place_ = 0;
  std::uint64_t sessions_ = 0;  // total number
  EndSession end_session_;
  std::string endpoint_;
  v1::BoardConfig config_;
  const RoutineTable* const routines_;
  const std::uint64_t max_memory_bytes_;
  const std::shared_ptr<const Checkpoint> start_;
  std::atomic<std::uint64_t> held_bytes_ = 0;
  Debugger debugger_;                         // thread-safe
  std::unique_ptr<Observation> observation_;  // used only by the owner's board
  std::unique_ptr<Board> board_;
  std::mutex saving_;  // prevents replacement of board_; locked before mutex_
  FaultPoint faults_;  // thread-safe
  boost::asio::thread_pool compute_{1};
};

}  // namespace gicube::emu

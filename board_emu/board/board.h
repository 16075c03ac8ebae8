// One GI-Cube board: everything behind the bus connector, with values and simulated time, without sockets.
//
// Input: transactions of the data plane in the order in which the host issued them, each with a timestamp of the host's
// clock. Output: replies and completions with timestamps in simulated time. Values are computed when a transaction
// arrives. Time is computed when it is final: up to the timestamp of the latest transaction, or up to the event that
// the host waits for.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "gicube/archive.h"
#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/counter_list.h"
#include "gicube/wire/frame.h"
#include "levels/level.h"
#include "words/words.h"

namespace gicube::emu {

struct Reply {
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::uint64_t time_ps = 0;
  std::vector<std::uint8_t> payload{};  // after an error: its text
};

// The result of a kCommand, in order of simulated time.
struct Completion {
  std::uint32_t ticket = 0;
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::uint64_t time_ps = 0;
  std::vector<std::uint8_t> payload;  // traced rays; after an error: its text
  bool can_be_cancelled = false;      // it has no effect on the board
};

// Result of one transaction. Completions are sent to the host before the reply.
struct TransactionResult {
  std::vector<Completion> completions;
  std::optional<Reply> reply;  // nothing for posted transactions
  // A command has the ticket of one in progress. Nothing was done, because the two completions could not be
  // distinguished.
  bool ticket_in_use = false;
};

inline constexpr std::uint64_t kUnlimitedMemory = ~std::uint64_t{0};

class BoardObserver;
class Routines;

class Board {
 public:
  // `config`: resolved and checked; the hash is its own (config.h). `observer`: for this board only, or null.
  // `routines`: for materials that trap; null: the built-in ones. Both must outlive the board. `max_memory_bytes`:
  // limit of the host memory for volume, words and image; requests beyond it are refused. A new board is in its
  // power-up state, with time and counters at 0.
  Board(const v1::BoardConfig& config, std::uint64_t config_hash, BoardObserver* observer = nullptr,
        const Routines* routines = nullptr, std::uint64_t max_memory_bytes = kUnlimitedMemory);
  ~Board();

  // Sets the host's minor version of the data plane; default: the board's own. Call before the first transaction.
  void set_minor_version(std::uint16_t minor);

  // Executes one transaction of type kConfigRead .. kCounters except kCompletion. Not thread-safe. Input from the host
  // never throws: errors become error replies, error completions, or for posted writes STATUS bits. Throws
  // std::bad_alloc if the system has less memory than the board may use; the board must not be used after that.
  TransactionResult transact(const wire::FrameHeader& header, std::span<const std::uint8_t> payload, Progress& work);

  // Executes the rest of a command that a checkpoint had in progress, if any. transact() and add_memory_error() do this
  // first. May be called when transact() may be.
  void go_on(Progress& work);

  // May be called when transact() may be. Detected errors: the next command that reads the volume fails with
  // ErrorCode::kMemory and changes nothing. Silent errors: the bit is wrong until it is written again; there is no
  // effect without a volume.
  void add_memory_error(const MemoryError& error);

  // Saves the complete state, or loads it into a board on which nothing was done. Loading may throw CheckpointFault;
  // the board must not be used after that. The level's state is loaded only if `with_level`; otherwise the level is in
  // its power-up state. May be called when transact() may be; also within a command from a job of at_next_moment(),
  // from Observer::see(), and from BoardObserver::begin_command(). The loading board then holds the command and
  // continues it in go_on().
  void state(Archive& archive, bool with_level = true);
  // Whether a command is in progress, or will be continued by go_on(). May be called when state() may be.
  bool in_command() const;
  // Calls `job` once, on the thread of the current or a later command, when state() may be called; perhaps never. It
  // must not throw. Thread-safe.
  void at_next_moment(std::function<void()> job);
  const v1::BoardConfig& config() const;

  // Memory in bytes of data that the host has not fetched: results, and records of transactions in progress. May be
  // called when transact() may be.
  std::uint64_t held_bytes() const;

  // State after the latest transaction. While the cycle level executes a command: state shortly after the last call of
  // this function. The machine is only inspected after a call: shortly after it and at the end of that command,
  // otherwise at the end of the next transaction. Thread-safe.
  struct Snapshot {
    std::uint64_t simulated_ps = 0;
    std::vector<wire::Counter> counters;
    MachineLook machine;
  };
  // Its counters include the energy up to then (config/energy.h).
  Snapshot snapshot() const;
  std::vector<wire::Counter> counters() const { return snapshot().counters; }
  // Host memory in bytes, as `max_memory_bytes` counts it; 0 without that limit.
  std::uint64_t memory_bytes() const {
    const std::lock_guard lock(published_mutex_);
    return published_memory_;
  }
  std::uint64_t simulated_ps() const {
    const std::lock_guard lock(published_mutex_);
    return published_.simulated_ps;
  }

 private:
  struct Parts;

  bool carry_out(const wire::FrameHeader& header, std::span<const std::uint8_t> payload, Progress& work);
  void do_jobs();
  void publish(bool with_machine);
  void publish_if_asked() {
    if (!is_asked_.load(std::memory_order_relaxed) || !is_asked_.exchange(false)) return;
    is_watched_ = true;
    publish(true);
  }

  std::unique_ptr<Parts> parts_;
  mutable std::atomic<bool> is_asked_ = false;  // since the last publish()
  bool is_watched_ = false;                     // in this transaction
  std::atomic<bool> has_jobs_ = false;
  std::mutex jobs_mutex_;  // for jobs_
  std::vector<std::function<void()>> jobs_;
  mutable std::mutex published_mutex_;
  Snapshot published_;
  std::uint64_t published_memory_ = 0;
};

}  // namespace gicube::emu

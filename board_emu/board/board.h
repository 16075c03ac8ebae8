// One GI-Cube board: everything behind the bus connector, values and simulated time, without sockets.
//
// What enters: transactions of the data plane in the order in which the host issued them, each stamped with the host's
// clock. What leaves: replies and completions stamped with simulated time. Values are computed as a transaction arrives;
// time is computed when it can no longer change: up to the stamp of the latest transaction, or up to what the host waits for.
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
  std::vector<std::uint8_t> payload{};  // with an error: its text
};

// The answer to a kCommand, in simulated-time order.
struct Completion {
  std::uint32_t ticket = 0;
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::uint64_t time_ps = 0;
  std::vector<std::uint8_t> payload;  // traced rays; with an error: its text
  bool can_be_cancelled = false;      // it leaves nothing on the board
};

// What one transaction brought about. Completions go to the host before the reply.
struct TransactionResult {
  std::vector<Completion> completions;
  std::optional<Reply> reply;  // nothing for posted transactions
  // A command came with the ticket of one that is under way: nothing was done, and no completion will tell the two apart.
  bool ticket_in_use = false;
};

inline constexpr std::uint64_t kUnlimitedMemory = ~std::uint64_t{0};

class BoardObserver;
class Routines;

class Board {
 public:
  // `config`: resolved and checked; the hash is its own (config.h). `observer`: of this board alone, or null. `routines`: for
  // materials that trap; null: the built-in ones. Both must outlive the board. `max_memory_bytes`: what volume, words and image
  // may take of the host's memory; what would take more is refused. A new board is as at power-up, its time and counters at 0.
  Board(const v1::BoardConfig& config, std::uint64_t config_hash, BoardObserver* observer = nullptr,
        const Routines* routines = nullptr, std::uint64_t max_memory_bytes = kUnlimitedMemory);
  ~Board();

  // The minor version of the data plane that the host speaks, before its first transaction; otherwise this board's own.
  void set_minor_version(std::uint16_t minor);

  // Carries out one transaction of type kConfigRead .. kCounters except kCompletion. One caller at a time. Nothing that a
  // host sends can throw: faults are error replies, error completions, or for posted writes STATUS bits. Throws std::bad_alloc
  // where the system has less memory than the board may take: it must not be used any more then.
  TransactionResult transact(const wire::FrameHeader& header, std::span<const std::uint8_t> payload, Progress& work);

  // Carries out the rest of a command that a checkpoint had under way, if there is one; transact() and add_memory_error() do so first.
  // Called like transact().
  void go_on(Progress& work);

  // Called like transact(). Detected: the next command that reads the volume fails with ErrorCode::kMemory and changes
  // nothing; there is no other harm. Silent: that bit is wrong until it is written again; without a volume nothing happens.
  void add_memory_error(const MemoryError& error);

  // Hands all that the board is to an archive that saves; or makes a board on which nothing was done what an archive that loads has,
  // which throws CheckpointFault: the board must not be used any more then. The level's own state is loaded if `with_level`; else the
  // level is as at power-up. Called like transact(), or in a command from a job of at_next_moment(), from Observer::see(), and
  // from BoardObserver::begin_command(). The board that loads has the command then, and goes on with it by go_on().
  void state(Archive& archive, bool with_level = true);
  // Whether a command is carried out, or will be by go_on(). Called like state().
  bool in_command() const;
  // Calls `job` once, on the thread of the command that is carried out, or of a later one, at a moment at which state() may be
  // called; perhaps never. It must not throw. Any thread.
  void at_next_moment(std::function<void()> job);
  const v1::BoardConfig& config() const;

  // Memory for what the host has not fetched: results, and the bookkeeping of what is under way. Called like transact().
  std::uint64_t held_bytes() const;

  // After the latest transaction. While the cycle level carries out a command: as it stood soon after the last call of this function.
  // The machine is looked at only for a call: soon after it and again at the end of that command, or else at the end of the next
  // transaction. Any thread.
  struct Snapshot {
    std::uint64_t simulated_ps = 0;
    std::vector<wire::Counter> counters;
    MachineLook machine;
  };
  Snapshot snapshot() const {
    is_asked_.store(true, std::memory_order_relaxed);
    const std::lock_guard lock(published_mutex_);
    return published_;
  }
  std::vector<wire::Counter> counters() const { return snapshot().counters; }
  // Memory of the host's, as `max_memory_bytes` counts it; 0 without that limit.
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
  mutable std::atomic<bool> is_asked_ = false;  // since they were published
  bool is_watched_ = false;                     // in this transaction
  std::atomic<bool> has_jobs_ = false;
  std::mutex jobs_mutex_;  // of jobs_
  std::vector<std::function<void()>> jobs_;
  mutable std::mutex published_mutex_;
  Snapshot published_;
  std::uint64_t published_memory_ = 0;
};

}  // namespace gicube::emu

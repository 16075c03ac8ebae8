// The board as seen from the bus: configuration space, registers, memory, DSP commands. The simulated host's clock
// stamps each transaction and advances with each answer.
//
// One caller at a time, except for clock().now() and close(). All calls throw DeviceLost, TimedOut; Rejected,
// Unsupported if the board refuses.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gicube/archive.h"
#include "gicube/board.h"
#include "gicube/wire/registers.h"
#include "transport/launch.h"
#include "transport/link.h"
#include "transport/pci_function.h"
#include "transport/uri.h"

namespace gicube {

// The clock of the simulated host (docs/reference/protocol.md, simulated time). It advances when the host works and
// when it waits for the board, never with the wall clock. now() may be called from any thread, the other calls by one
// caller at a time.
class HostClock {
 public:
  Picoseconds now() const { return now_.load(std::memory_order_relaxed); }

  // The host works for `duration`. Saturates at the largest time.
  void work(Picoseconds duration) {
    now_.store(now() + std::min(duration, kNoDeadline - now()), std::memory_order_relaxed);
  }

  // The host was blocked until `time`. Earlier times change nothing.
  void wait_until(Picoseconds time) {
    if (time > now()) now_.store(time, std::memory_order_relaxed);
  }

  void set(Picoseconds now) { now_.store(now, std::memory_order_relaxed); }

 private:
  std::atomic<Picoseconds> now_{0};
};

class Device {
 public:
  // Connects, or starts a private board. An exception of `while_waiting` propagates out of the waiting call. Throws
  // OpenFailed, BoardBusy, VersionMismatch, TimedOut, BadArgument.
  Device(const Uri& uri, const OpenOptions& options, std::function<void()> while_waiting);

  // After DeviceLost or TimedOut, connects again. True: the session continues, and nothing was lost. False: a new
  // session, on a board in its reset state. Throws as the constructor, and DeviceLost: the device is still lost.
  bool reopen();

  const wire::VersionInfo& agreed() const { return link_->agreed(); }
  HostClock& clock() { return clock_; }
  const HostClock& clock() const { return clock_; }
  // Throws Unsupported unless the board speaks protocol 2.`minor`, which `what`, for instance "checkpoints need".
  void need_minor(std::uint16_t minor, const char* what) const;
  // Throws DeviceLost if the board is lost.
  void check();
  // Ends the session; any thread. All waiting and later calls throw DeviceLost.
  void close() { link_->close(); }
  [[noreturn]] void give_up(const std::string& reason) { link_->give_up(reason); }

  std::uint32_t read_config(std::uint32_t offset) { return read_word(wire::FrameType::kConfigRead, offset); }
  std::uint32_t read_register(std::uint32_t offset) { return read_word(wire::FrameType::kRegisterRead, offset); }
  void write_register(std::uint32_t offset, std::uint32_t value);
  void set_register(std::uint32_t offset, std::uint32_t value) {
    const auto last = registers_.find(offset);
    if (last == registers_.end() || last->second != value) write_register(offset, value);
  }
  // Resets the board to its power-up state.
  void reset() {
    write_register(wire::reg::kControl, wire::kControlReset);
    registers_.clear();
    for (const wire::RegisterInfo& info : wire::kRegisterTable) {
      if (info.access == wire::Access::kReadWrite) registers_[info.offset] = info.reset;
    }
  }
  // Values of the registers that were written; after reset(), of all that can be read and written.
  const std::map<std::uint32_t, std::uint32_t>& registers() const { return registers_; }

  // Writes in pieces that the link's payload limit allows, each of whole dwords, LUT entries and pairs of voxels.
  void write_memory(std::uint64_t address, std::span<const std::uint8_t> bytes);
  // Reads in pieces that the link's payload limit allows, each of whole records of `record` bytes.
  std::vector<std::uint8_t> read_memory(std::uint64_t address, std::uint64_t length, std::size_t record);

  std::uint32_t command(wire::Payload payload);
  // Blocks the simulated host until the command has completed. Throws DeadlinePassed if it has not by the simulated
  // time `deadline`. An error of the command is in the result, and not thrown. After an exception the result can still
  // arrive.
  CommandResult finish(std::uint32_t ticket, const Progress& progress, Picoseconds deadline = kNoDeadline);
  // finish(); throws what the result's error stands for.
  CommandResult finish_or_throw(std::uint32_t ticket, const Progress& progress = {},
                                Picoseconds deadline = kNoDeadline);
  // command() and finish_or_throw(). If it throws, the result is dropped.
  CommandResult run(std::vector<std::uint8_t> payload, const Progress& progress, Picoseconds deadline = kNoDeadline);
  // The result of a command, if it has arrived. Does not block.
  std::optional<CommandResult> take(std::uint32_t ticket) { return link_->take(ticket); }
  void forget(std::uint32_t ticket) { link_->forget(ticket); }
  // Cancels a command that the board has not begun: true, and it completes with kCancelled. False: it is too late.
  bool cancel(std::uint32_t ticket);
  // Fetches the results of all commands that have completed by now.
  void poll() { request(wire::FrameType::kPoll, {}); }
  // A position in the stream, made without waiting. The board answers it once it has processed everything sent before.
  // The clock does not advance.
  struct Mark {
    std::shared_ptr<Link> link;
    std::uint32_t request = 0;  // Link::finish()
  };
  Mark mark();

  Counters counters();

  // Checkpoints (wire::CheckpointStep). The clock does not advance. All calls throw Unsupported for a board of an
  // earlier protocol. When begin_checkpoint() returns, all results that the board has sent have arrived.
  void begin_checkpoint() { checkpoint_step(wire::CheckpointStep::kBegin, {}); }
  // Has the board make a checkpoint that includes the driver's part, and passes it to `sink` in pieces.
  void take_checkpoint(std::span<const std::uint8_t> driver,
                       const std::function<void(std::span<const std::uint8_t>)>& sink);
  // The board continues from the checkpoint, or, if that is empty, from the one of its process. Throws Rejected: the
  // board is unchanged.
  wire::WentOn go_on(std::span<const std::uint8_t> checkpoint);
  // After go_on(): the driver's part.
  std::vector<std::uint8_t> read_driver_part(std::uint64_t bytes);

  // This device's state apart from the board's own.
  struct Remembered {
    Picoseconds now = 0;
    std::map<std::uint32_t, std::uint32_t> registers{};
    Link::Commands commands{};
    std::uint32_t last_id = 0;  // of a request or command, since messages name tickets

    void state(Archive& archive);
  };
  Remembered remembered() const { return {clock_.now(), registers_, link_->commands(), link_->last_id()}; }
  std::uint32_t last_id() const { return link_->last_id(); }
  void set_last_id(std::uint32_t id) { link_->set_last_id(id); }
  void remember(Remembered from) {
    clock_.set(from.now);
    registers_ = std::move(from.registers);
    link_->set_commands(std::move(from.commands));
    link_->set_last_id(from.last_id);
  }

 private:
  std::vector<std::uint8_t> checkpoint_step(wire::CheckpointStep step, std::span<const std::uint8_t> what);
  void write_checkpoint(std::span<const std::uint8_t> bytes);
  void read_checkpoint(std::uint64_t bytes, const std::function<void(std::span<const std::uint8_t>)>& sink);

  std::shared_ptr<Link> open_link();
  std::vector<std::uint8_t> request(wire::FrameType type, std::vector<std::uint8_t> payload);
  std::uint32_t read_word(wire::FrameType type, std::uint32_t offset);
  auto with_last_words(const auto& call) const;

  const Uri uri_;
  const std::string capture_file_;
  unsigned captures_ = 0;  // sessions so far
  LinkOptions link_options_;
  std::unique_ptr<ChildProcess> child_;    // declared before the link: it ends once the link is closed
  std::unique_ptr<PciFunction> function_;  // the same
  std::shared_ptr<Link> link_;             // shared with those who wait for a mark
  HostClock clock_;
  std::map<std::uint32_t, std::uint32_t> registers_;  // as last written, for set_register()
};

}  // namespace gicube

// The board as a host sees it through its bus connector: configuration space, registers, memory, DSP commands; and the
// simulated host's clock, which stamps each transaction and moves with each answer.
//
// One caller at a time, but clock().now(). All calls throw DeviceLost, TimedOut; Rejected, Unsupported if the board
// refuses.
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

// The clock of the simulated host (docs/reference/protocol.md, simulated time). It moves when the host works and when
// it waits for the board, never with the wall clock. now() may be read from any thread; the two others by one caller at
// a time.
class HostClock {
 public:
  Picoseconds now() const { return now_.load(std::memory_order_relaxed); }

  // The host works for `duration`. Stays at the end of time instead of starting again at 0.
  void work(Picoseconds duration) {
    now_.store(now() + std::min(duration, kNoDeadline - now()), std::memory_order_relaxed);
  }

  // The host was blocked until `time`; what lies in its past does not move it.
  void wait_until(Picoseconds time) {
    if (time > now()) now_.store(time, std::memory_order_relaxed);
  }

  void set(Picoseconds now) { now_.store(now, std::memory_order_relaxed); }

 private:
  std::atomic<Picoseconds> now_{0};
};

class Device {
 public:
  // Connects, or starts a private board. What `while_waiting` throws leaves the call that waits. Throws OpenFailed,
  // BoardBusy, VersionMismatch, TimedOut, BadArgument.
  Device(const Uri& uri, const OpenOptions& options, std::function<void()> while_waiting);

  // After DeviceLost or TimedOut, connects again. True: the session goes on, and nothing was lost. False: this is a
  // board that knows nothing of us. Throws as the constructor and DeviceLost: the device is as lost as before.
  bool reopen();

  const wire::VersionInfo& agreed() const { return link_->agreed(); }
  HostClock& clock() { return clock_; }
  const HostClock& clock() const { return clock_; }
  // Throws DeviceLost if the board is.
  void check();
  // Ends the session; any thread. All that waits, and all later calls, throw DeviceLost.
  void close() { link_->close(); }
  [[noreturn]] void give_up(const std::string& reason) { link_->give_up(reason); }

  std::uint32_t read_config(std::uint32_t offset) { return read_word(wire::FrameType::kConfigRead, offset); }
  std::uint32_t read_register(std::uint32_t offset) { return read_word(wire::FrameType::kRegisterRead, offset); }
  void write_register(std::uint32_t offset, std::uint32_t value);
  void set_register(std::uint32_t offset, std::uint32_t value) {
    const auto last = registers_.find(offset);
    if (last == registers_.end() || last->second != value) write_register(offset, value);
  }
  // All of the board's state as at power-up.
  void reset() {
    write_register(wire::reg::kControl, wire::kControlReset);
    registers_.clear();
    for (const wire::RegisterInfo& info : wire::kRegisterTable) {
      if (info.access == wire::Access::kReadWrite) registers_[info.offset] = info.reset;
    }
  }
  // Values of registers that can be read and written: all of them once reset() has been called.
  const std::map<std::uint32_t, std::uint32_t>& registers() const { return registers_; }

  // In pieces that the link's payload limit allows, each of whole dwords, LUT entries and pairs of voxels.
  void write_memory(std::uint64_t address, std::span<const std::uint8_t> bytes);
  // At most agreed().max_payload_bytes.
  std::vector<std::uint8_t> read_memory(std::uint64_t address, std::uint64_t length);

  std::uint32_t command(wire::Payload payload);
  // Blocks the simulated host until the command has completed, but no longer than to the simulated time `deadline`:
  // throws DeadlinePassed then. Its error is in the result, and not thrown. Whatever is thrown, the result can still
  // come.
  CommandResult finish(std::uint32_t ticket, const Progress& progress, Picoseconds deadline = kNoDeadline);
  // Both, and throws what the result's error stands for. If it throws, nobody asks for the result any more.
  CommandResult run(std::vector<std::uint8_t> payload, const Progress& progress, Picoseconds deadline = kNoDeadline);
  // The result of a command if it has come; blocks nobody.
  std::optional<CommandResult> take(std::uint32_t ticket) { return link_->take(ticket); }
  void forget(std::uint32_t ticket) { link_->forget(ticket); }
  // Takes a command back whose turn has not begun: true, and it completes with kCancelled.
  bool cancel(std::uint32_t ticket);
  // Fetches the results of all commands that have completed by now.
  void poll() { request(wire::FrameType::kPoll, {}); }
  // A position in the stream that needs no wait: the board answers once it has processed everything sent before. No
  // clock moves.
  struct Mark {
    std::shared_ptr<Link> link;
    std::uint32_t request = 0;  // Link::finish()
  };
  Mark mark();

  Counters counters();

  // Checkpoints (wire::CheckpointStep); no clock moves. All throw Unsupported if the board is of an earlier protocol.
  // Once it returns, all results that the board has sent are here.
  void begin_checkpoint() { checkpoint_step(wire::CheckpointStep::kBegin, {}); }
  // The board's checkpoint with the driver's part, piece by piece.
  void take_checkpoint(std::span<const std::uint8_t> driver,
                       const std::function<void(std::span<const std::uint8_t>)>& sink);
  // The board becomes what the checkpoint says; without one, what its process began with. Throws Rejected: it is as
  // before.
  wire::WentOn go_on(std::span<const std::uint8_t> checkpoint);
  // After go_on(): the driver's part.
  std::vector<std::uint8_t> read_driver_part(std::uint64_t bytes);

  // This device's state apart from the board's own.
  struct Remembered {
    Picoseconds now = 0;
    std::map<std::uint32_t, std::uint32_t> registers{};
    Link::Commands commands{};
    std::uint32_t last_id = 0;  // of a request or command: tickets are named in messages

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
  unsigned captures_ = 0;  // sessions that were begun
  LinkOptions link_options_;
  std::unique_ptr<ChildProcess> child_;    // before the link: it ends by itself once the link has closed
  std::unique_ptr<PciFunction> function_;  // the same
  std::shared_ptr<Link> link_;             // shared with who waits for a mark
  HostClock clock_;
  std::map<std::uint32_t, std::uint32_t> registers_;  // as last written, for set_register()
};

}  // namespace gicube

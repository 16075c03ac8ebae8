// The driver's end of the data plane: handshake, credits, requests with their responses, commands with their completions.
//
// A Link may be used from several threads. Each call stands in the stream in the order in which it got its credit.
// Once the link is broken every waiting and every later call throws DeviceLost with the reason.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fd.h"
#include "frame_stream.h"
#include "gicube/time.h"
#include "gicube/wire/credits.h"
#include "gicube/wire/frame.h"

namespace gicube {

// What a driver of this version says of itself in the handshake.
wire::VersionInfo driver_version();

struct LinkOptions {
  // Wall-clock limit between two signs of life of the board while a call waits; 0 = none.
  std::chrono::milliseconds watchdog{0};
  wire::VersionInfo mine = driver_version();
};

struct Response {
  wire::ErrorCode error = wire::ErrorCode::kNone;  // kDeadline, or else thrown
  std::uint64_t time_ps = 0;
  std::vector<std::uint8_t> payload;
};

struct CommandResult {
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::uint64_t time_ps = 0;
  std::vector<std::uint8_t> payload;  // with an error: its text
};

class Link : private FrameSink {
 public:
  using OnProgress = std::function<void(std::uint32_t done, std::uint32_t all)>;

  // Takes a connected stream socket and agrees on a version.
  // Throws OpenFailed (no board there), BoardBusy, VersionMismatch, TimedOut.
  Link(Fd socket, const LinkOptions& options);
  ~Link() = default;

  // What holds for the session: the smaller minor version and limits, the common capabilities.
  const wire::VersionInfo& agreed() const { return agreed_; }

  // Throws DeviceLost if the link is broken.
  void check() const;

  // Ends the session: the board said something that it can't have meant. Throws DeviceLost with the reason.
  [[noreturn]] void give_up(const std::string& reason);

  // Sends a frame that has no response. Waits for credit. Throws DeviceLost, TimedOut, and BadArgument if the payload
  // is beyond the agreed limit.
  void post(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload);

  // Sends a request and waits for its response. Throws as post(), and what the board's error reply stands for.
  Response request(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload);

  // Posts a DSP command; its result is kept until it is taken or forgotten. Returns the ticket, which is never 0.
  std::uint32_t command(std::uint64_t now_ps, std::vector<std::uint8_t> payload);

  // Waits until the command has completed on the board, or simulated time has come to `deadline` (kNoDeadline: none): the
  // response's error says which. `on_progress` is called on this thread, with no lock held; what
  // it throws leaves this call and the command goes on.
  Response wait(std::uint32_t ticket, std::uint64_t now_ps, Picoseconds deadline, const OnProgress& on_progress);

  // The result of a command, once; nothing while it has not come.
  std::optional<CommandResult> take(std::uint32_t ticket);

  // Nobody will take the result: it is dropped when it comes.
  void forget(std::uint32_t ticket);

 private:
  enum class Phase { kHandshake, kOpen, kBroken };

  struct Pending {
    wire::FrameType type{};
    std::uint32_t watched_ticket = 0;  // progress of this command interests the caller; 0 = none
    std::optional<std::pair<std::uint32_t, std::uint32_t>> progress;
    bool abandoned = false;
    std::optional<Response> response;
    wire::ErrorCode error = wire::ErrorCode::kNone;
  };

  struct Command {
    bool forgotten = false;
    std::optional<CommandResult> result;
  };

  using Lock = std::unique_lock<std::mutex>;

  std::string check_header(const wire::FrameHeader& header) override;
  std::string take_frame(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) override;
  void stream_ended(const std::string& reason) override;

  void shake_hands();
  std::string take_version(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);
  std::string check_frame(const wire::FrameHeader& header);
  std::string take_credit(const wire::FrameHeader& header);
  void take_response(const wire::FrameHeader& header, std::vector<std::uint8_t> payload);
  void take_completion(const wire::FrameHeader& header, std::vector<std::uint8_t> payload);
  void take_progress(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);

  Response exchange(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload,
                    std::uint32_t watched_ticket, const OnProgress& on_progress);
  void await_response(Lock& lock, std::uint32_t id, const OnProgress& on_progress);
  void await_credit(Lock& lock, std::size_t payload);
  template <typename Ready>
  void await(Lock& lock, const Ready& ready);
  void send_with_credit(wire::FrameHeader header, std::vector<std::uint8_t> payload);
  std::uint32_t next_id();
  void throw_if_broken() const;
  void break_off(const std::string& reason);
  [[noreturn]] void expire();

  const LinkOptions options_;
  wire::VersionInfo agreed_;  // written once, before the constructor returns

  mutable std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  Phase phase_ = Phase::kHandshake;
  std::string broken_reason_;
  wire::ErrorCode refusal_ = wire::ErrorCode::kNone;  // of the handshake
  std::chrono::steady_clock::time_point last_heard_;
  wire::SendCredits send_credits_{0, 0};
  std::uint64_t unreturned_slots_ = 0;  // frames and payload bytes that the peer has not handed back
  std::uint64_t unreturned_bytes_ = 0;
  wire::ReceiveCredits receive_credits_;
  std::uint32_t sent_ = 0;  // sequence numbers of the last frames sent and taken
  std::uint32_t taken_ = 0;
  std::uint32_t last_id_ = 0;
  std::map<std::uint32_t, Pending> pending_;
  std::map<std::uint32_t, Command> commands_;

  FrameStream stream_;  // last: its thread ends before what it reports to
};

}  // namespace gicube

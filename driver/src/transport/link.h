// The driver's end of the data plane: handshake, credits, requests with their responses, commands with their
// completions.
//
// A Link may be used from several threads. The calls are sent in the order in which they got their credit. If the
// connection breaks, the session can be resumed over another one (reliable_window.h). Until then, if the link may not
// resume by itself, every waiting and every later call throws DeviceLost with the reason.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fd.h"
#include "frame_stream.h"
#include "gicube/error.h"
#include "gicube/time.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/reliable_window.h"

namespace gicube {

wire::VersionInfo driver_version();

struct LinkOptions {
  // Wall-clock limit without a sign of life from the board while a call waits; 0 = none.
  std::chrono::milliseconds watchdog{0};
  wire::VersionInfo mine = driver_version();  // with its flags and wait_ms
  // Connects again after a loss; throws OpenFailed or TimedOut. Empty: the connection can't be made again.
  std::function<Fd()> reconnect{};
  // The access token for the board at this socket. Must not throw. Empty: none is needed.
  std::function<std::string(int socket)> token{};
  std::shared_ptr<Tls> tls{};  // null: plain bytes
  // How often in a row the link resumes its session by itself while the board has taken and sent nothing.
  int reopen_attempts = 0;
  // Called on the waiting thread. Its exceptions leave the call as those of a progress callback do.
  std::function<void()> while_waiting{};
  // A call that has waited so long in silence asks whether something was lost on the way. `while_waiting` is called at
  // the same intervals.
  std::chrono::milliseconds probe{100};  // chosen: ten frames a second
  // Receives what no call reports, on the thread of a call. Must not throw.
  std::function<void(const std::string&)> log{};
  FrameTap tap{};
};

struct Response {
  wire::ErrorCode error = wire::ErrorCode::kNone;  // of a request: kDeadline, or else thrown
  std::uint64_t time_ps = 0;
  std::vector<std::uint8_t> payload;  // with an error: its text
};
using CommandResult = Response;

// The text of an error payload: printable, and truncated to a length that fits a message.
std::string error_text(std::span<const std::uint8_t> payload);

// True if the board closes the session with this error.
bool ends_session(wire::ErrorCode code);

// Returns the cause of the loss that this error in the board's last frame stands for.
Loss cause_of(wire::ErrorCode last_word);

// Throws what `code` stands for, `text` being the board's own words. Only for codes other than kNone.
[[noreturn]] void throw_error(wire::ErrorCode code, const std::string& text);

class Link final : private FrameSink {
 public:
  using OnProgress = std::function<void(std::uint32_t done, std::uint32_t all)>;

  // Takes a connected stream socket. Throws OpenFailed (no board there), BoardBusy, VersionMismatch, TimedOut.
  Link(Fd socket, const LinkOptions& options);
  // Says goodbye: the board is free at once.
  ~Link();

  // The values agreed for the session: the smaller minor version and limits, the common capabilities.
  const wire::VersionInfo& agreed() const { return agreed_; }

  // Throws DeviceLost if the link is broken and can't resume by itself.
  void check() {
    Lock lock(mutex_);
    if (phase_ == Phase::kBroken) recover_or_throw(lock);
  }

  bool is_broken() const {
    const std::lock_guard lock(mutex_);
    return phase_ == Phase::kBroken;
  }
  // After DeviceLost or TimedOut: resumes the session over a new connection, made by LinkOptions::reconnect. False: the
  // board no longer has the session, or there is none to resume. Throws what `reconnect` does, DeviceLost, TimedOut.
  bool resume();

  // Ends the session because the board sent something that can't be right. Throws DeviceLost with the reason.
  [[noreturn]] void give_up(const std::string& reason);

  // Sends a frame that has no response. Waits for credit. Throws DeviceLost, TimedOut, BadArgument (a payload too
  // large).
  void post(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload);

  // Ends the session because the application closes it. All waiting calls throw DeviceLost.
  void close();

  // Sends a request and waits for its response. Throws as post(), and what the board's error reply stands for.
  Response request(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload) {
    return finish(begin(type, now_ps, std::move(payload)));
  }
  // A request in two calls: begin() returns its id, and finish() waits, possibly on another thread.
  std::uint32_t begin(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload) {
    return begin(type, now_ps, std::move(payload), 0);
  }
  Response finish(std::uint32_t id) { return finish(id, {}); }

  // Posts a DSP command; its result is kept until it is taken or forgotten. Returns the ticket, which is never 0.
  std::uint32_t command(std::uint64_t now_ps, wire::Payload payload);

  // Waits until the command has completed on the board, or simulated time has come to `deadline` (kNoDeadline: none):
  // the response's error says which. An exception of `on_progress`, which is called on this thread, leaves this call;
  // the command continues.
  Response wait(std::uint32_t ticket, std::uint64_t now_ps, Picoseconds deadline, const OnProgress& on_progress);

  // The result of a command, which can be taken once. Nothing if it has not arrived.
  std::optional<CommandResult> take(std::uint32_t ticket);

  // Nobody will take the result: it is dropped when it arrives.
  void forget(std::uint32_t ticket);

  // Commands whose results have not arrived, or were not taken, by ticket.
  struct Command {
    bool forgotten = false;
    std::optional<CommandResult> result{};
  };
  using Commands = std::map<std::uint32_t, Command>;
  Commands commands() const {
    const std::lock_guard lock(mutex_);
    return commands_;
  }
  // The board has become one on which these commands are running.
  void set_commands(Commands commands) {
    const std::lock_guard lock(mutex_);
    commands_ = std::move(commands);
  }
  // The number of the last request or command. If it is set back, the numbers after it are given again: they must have
  // been answered.
  std::uint32_t last_id() const {
    const std::lock_guard lock(mutex_);
    return last_id_;
  }
  void set_last_id(std::uint32_t id) {
    const std::lock_guard lock(mutex_);
    last_id_ = id;
  }

 private:
  enum class Phase { kHandshake, kOpen, kBroken };

  struct Pending {
    wire::FrameType type{};
    std::uint32_t watched_ticket = 0;  // progress of this command interests the caller; 0 = none
    std::optional<std::pair<std::uint32_t, std::uint32_t>> progress;
    bool abandoned = false;
    std::optional<Response> response;
  };

  using Lock = std::unique_lock<std::mutex>;
  using Clock = std::chrono::steady_clock;

  StreamFault check_header(const wire::FrameHeader& header) override;
  StreamFault take_frame(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) override;
  void stream_ended(const StreamFault& reason) override;

  void shake_hands(Lock& lock, Fd socket, std::chrono::milliseconds limit);
  void ask_whether_to_wait(Lock& lock);
  [[noreturn]] void refuse_to_open();
  StreamFault take_version(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);
  StreamFault take_up_session(const wire::VersionInfo& theirs);
  StreamFault check_frame(const wire::FrameHeader& header);
  void take_response(const wire::FrameHeader& header, std::vector<std::uint8_t> payload);
  void take_completion(const wire::FrameHeader& header, std::vector<std::uint8_t> payload);
  void take_progress(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);

  // Progress may arrive as soon as the board has the request: so the watched ticket is set before.
  std::uint32_t begin(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload,
                      std::uint32_t watched_ticket);
  Response finish(std::uint32_t id, const OnProgress& on_progress);
  void await_response(Lock& lock, std::uint32_t id, const OnProgress& on_progress);
  wire::FrameHeader next_header(Lock& lock, wire::FrameType type, std::uint16_t flags, std::uint64_t now_ps,
                                std::size_t payload);
  void await(Lock& lock, const auto& ready, bool may_leave = false);
  void send_with_credit(const wire::FrameHeader& header, wire::Payload payload);
  void send_credit(std::uint16_t flags) { stream_->send(window_.credit_frame(flags), wire::no_payload()); }
  bool can_recover() const {
    const bool may_come_back = broken_.cause != Loss::kTakenOver && broken_.cause != Loss::kEnded;
    return may_come_back && session_ != 0 && options_.reconnect && attempts_ < options_.reopen_attempts;
  }
  void recover(Lock& lock);
  void recover_or_throw(Lock& lock) {
    recover(lock);
    if (phase_ == Phase::kBroken) throw_broken();
  }
  [[noreturn]] void throw_broken() const { throw DeviceLost("the board is lost: " + broken_.text, broken_.cause); }
  void break_off(const StreamFault& reason);

  const LinkOptions options_;
  wire::VersionInfo agreed_;  // written once, before the constructor returns

  mutable std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  Phase phase_ = Phase::kHandshake;
  StreamFault broken_;
  wire::ErrorCode refusal_ = wire::ErrorCode::kNone;  // of the handshake
  std::uint64_t session_ = 0;                         // its token; 0 = it can't be resumed
  bool closed_ = false;                               // by close()
  int attempts_ = 0;                                  // to resume, since the board last took or sent something
  std::uint32_t known_taken_ = 0;  // the last frame of ours that the board has said it took, when it was resumed
  bool deaf_ = false;              // what the stream reports belongs to a connection that is given up
  Clock::time_point last_heard_;   // of a sign of life
  Clock::time_point last_frame_;   // any frame either way that a probe would only repeat
  wire::ReliableWindow window_;
  std::uint32_t last_id_ = 0;
  std::map<std::uint32_t, Pending> pending_;
  Commands commands_;

  std::unique_ptr<FrameStream> stream_;  // last: its thread ends before what it reports to
};

}  // namespace gicube

// The session of one owner of a board: from the claim to the reset, over any number of connections.
//
// A reader moves frames from the connection to an inbox, which the granted credits limit. The worker takes them one by
// one, has the board execute them on its compute thread, and sends the results as far as the client's credits allow.
// Sent frames are kept until their credit is returned. After a broken connection the client resumes the session with
// its token, and each side sends again what the other has not taken. Everything except the jobs on the compute thread
// runs on the io thread, so nothing is locked.
//
// An error of the client ends its session with a message. However a session ends, its board is destroyed before the
// next session, which gets a new one.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "board_slot.h"
#include "connection.h"
#include "gicube/access.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/reliable_window.h"
#include "server/audit.h"
#include "tls.h"

namespace gicube::emu {

wire::VersionInfo board_version();

struct BusOptions {
  wire::VersionInfo version = board_version();
  std::chrono::milliseconds handshake_deadline{5000};  // chosen: as long as a person would wait
  std::chrono::milliseconds progress_interval{100};    // chosen: often enough for a progress bar
  std::shared_ptr<Tls> tls{};                          // for TCP; null: plain TCP
  Audit* audit = nullptr;                              // must outlive the server; may be null
  // Limit of this machine's time for one frame; 0 = no limit.
  std::chrono::milliseconds max_command_time{0};
  std::vector<AccessToken> tokens{};  // a client over TCP must have one of these
  // Refusals of clients with a wrong token are delayed, with increasing pauses.
  std::chrono::milliseconds token_pause{100};            // chosen: at first ten guesses per second
  std::chrono::milliseconds longest_token_pause{2'000};  // chosen: acceptable for a user who has used a wrong file
  std::size_t max_unowned = 32;                          // chosen: connections that do not own a board (yet)
  std::size_t max_unowned_of_peer = 16;                  // chosen: per address, or per process on this machine
  std::chrono::milliseconds max_wait{3'600'000};         // chosen: for the board; longer than a batch of frames
  // Time between two takeovers of a board by force: the first pause, and the maximum to which it doubles.
  std::chrono::milliseconds force_pause{2'000};           // chosen: more than an owner needs to open and write a volume
  std::chrono::milliseconds longest_force_pause{60'000};  // chosen: retries in a loop get the board once per minute
  // How long a session without a connection can be resumed, while no other client requests the board; 0 = it ends at
  // once.
  std::chrono::milliseconds resume_limit{10'000};  // chosen: covers a short interruption of the network
  // Limit of data held for a client: results that it has not waited or polled for, frames whose credit it has not
  // returned.
  std::uint64_t max_held_bytes = std::uint64_t{1} << 30;  // chosen: 32 million rays
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  // A session for an owner of `slot` whose version is `theirs`. `token` identifies the session. All references must
  // outlive it.
  Session(const Connection::Executor& executor, BoardSlot& slot, const BusOptions& options, std::uint64_t token,
          const wire::VersionInfo& agreed, const wire::VersionInfo& theirs);

  bool ended() const { return stopped_; }
  bool serves(const BoardSlot& slot) const { return &slot_ == &slot; }

  // Why a client with this version frame cannot resume the session; empty if it can.
  std::string resume_fault(const wire::VersionInfo& theirs) const;
  // Call before attach(). Builds a board if the slot has none. Returns the error if that fails or the session has ended
  // meanwhile.
  awaitable<std::string> prepare();
  // Answers version frame `id` of a client that opens or resumes this session, and continues over its connection.
  void attach(std::shared_ptr<Connection> connection, std::uint32_t id, const wire::VersionInfo& theirs);

  // Works until the session has ended. The board is then free again. `can_resume`: a broken connection does not end the
  // session.
  awaitable<void> run(bool can_resume);

  // Ends the session with a message to the client. May be called at any time on the io thread.
  void end(wire::ErrorCode error, std::string text) { fail({error, 0, std::move(text)}); }

 private:
  struct Frame : Connection::Frame {
    std::optional<MemoryError> memory_error;  // from the fault plan
  };
  using Connected = std::shared_ptr<Connection>;
  static constexpr std::chrono::milliseconds kUntilWoken = std::chrono::hours(24);

  static awaitable<void> read_frames(std::shared_ptr<Session> self, Connected connection);
  awaitable<bool> take(const Connected& connection, Connection::Frame frame);
  awaitable<bool> take_numbered(const Connected& connection, Connection::Frame frame);
  void admit(const wire::FrameHeader& header);

  awaitable<void> work();
  std::uint64_t held() const;
  void check_held(const wire::FrameHeader& header) const;
  awaitable<TransactionResult> transact(const Frame& frame);
  // Handles a kCheckpoint frame. The step runs on the compute thread.
  awaitable<TransactionResult> checkpoint(const Frame& frame);
  void checkpoint_step(std::span<const std::uint8_t> payload, Reply& reply);
  wire::WentOn go_on();
  awaitable<void> send_result(const wire::FrameHeader& request, TransactionResult result);
  awaitable<void> keep_pace(std::uint64_t time_ps);
  void send_progress();
  void return_credit();
  awaitable<void> send(wire::FrameHeader header, std::vector<std::uint8_t> payload);
  awaitable<void> deliver(const wire::ReliableWindow::Sent& frame);
  void put(wire::FrameHeader header, wire::Payload payload, std::optional<std::uint32_t> flipped_bit = std::nullopt);
  // Rethrows the exceptions of the job.
  awaitable<void> run_on_compute(std::function<void()> job, bool shows_progress,
                                 std::chrono::milliseconds limit = std::chrono::milliseconds{0});
  void note(AuditEvent event, const std::string& what) const {
    if (options_.audit != nullptr) options_.audit->note(event, peer_, fmt::format("board {}: {}", slot_.index(), what));
  }

  awaitable<void> give_board_back();
  void end_for_its_time(std::chrono::milliseconds limit);
  // Ends early if the session ends.
  awaitable<void> pause(std::chrono::microseconds duration) {
    return sleep_unless(wake_.get_executor(), duration, [this] { return stopped_; });
  }
  void lose(const Connected& connection, const std::optional<LastWord>& word);
  // Errors that clients should not be able to cause: lack of memory, or an internal fault.
  void fail(const std::exception& error);
  // Only the first fault is reported to the client.
  void fail(const LastWord& fault) {
    if (stopped_) return;
    stop();
    if (!connection_) return;
    connection_->refuse(fault);
    connection_.reset();
  }
  void stop() {
    if (stopped_) return;
    stopped_ = true;
    progress_.cancel = true;
    absence_.cancel();
    wake_.cancel();
  }

  BoardSlot& slot_;
  const BusOptions& options_;
  const std::uint64_t token_;
  const wire::VersionInfo agreed_;
  const bool realtime_;
  bool can_resume_ = true;
  bool is_private_ = false;  // the board process belongs to this client
  bool has_worked_ = false;  // the board has executed something in this session
  std::string checkpoint_;   // the buffer of kCheckpoint frames

  Connected connection_;  // null while the client is away
  std::string peer_;      // name of the current or latest client
  wire::ReliableWindow window_;
  std::uint32_t judged_ = 0;  // last number that the fault plan has processed

  std::uint64_t held_bytes_ = 0;  // held by the board after the latest transaction

  std::deque<Frame> inbox_;
  Progress progress_;
  bool job_done_ = false;
  bool delivering_ = false;  // a frame is numbered and is delayed by the fault plan
  bool stopped_ = false;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();

  asio::steady_timer wake_;     // the worker sleeps on it and is woken by cancelling it
  asio::steady_timer absence_;  // running while the client is away
};

}  // namespace gicube::emu

// One owner's time on a board: from the claim to the reset, over as many connections as it takes.
//
// A reader takes frames off the connection into an inbox that the granted credits bound. The worker takes them out one by
// one, has the board carry them out on its compute thread, and sends what comes of it as far as the client's credits reach.
// What was sent is kept until its credit has come back: after a broken connection the client resumes the session by its token,
// and each side sends again what the other has not taken. All but Board::transact runs on the io thread: nothing is locked.
//
// A fault of the client ends its session with a last word. However a session ends, its board is gone before the next one, which
// has a new board.
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
  std::chrono::milliseconds handshake_deadline{5000};  // chosen: a person's patience
  std::chrono::milliseconds progress_interval{100};    // chosen: as often as a progress bar is read
  std::shared_ptr<Tls> tls{};                          // of TCP; null: plain bytes
  Audit* audit = nullptr;                              // must outlive the server; null: there is none
  // What one frame may have the board work, of this machine's time; 0 = no limit.
  std::chrono::milliseconds max_command_time{0};
  std::vector<AccessToken> tokens{};  // one of which a client over TCP must have
  // A client with a wrong token waits for its refusal, each time longer.
  std::chrono::milliseconds token_pause{100};            // chosen: ten guesses a second at first
  std::chrono::milliseconds longest_token_pause{2'000};  // chosen: within the patience of whoever has mistaken a file
  std::size_t max_unowned = 32;                          // chosen: connections that own no board (yet)
  std::size_t max_unowned_of_peer = 16;                  // chosen: of one address, or of one process on this machine
  std::chrono::milliseconds max_wait{3'600'000};         // chosen: for the board; longer than a batch of frames takes
  // Between two times that a board is taken by force: the first pause, and the longest, to which it doubles.
  std::chrono::milliseconds force_pause{2'000};  // chosen: more than an owner needs to open and write a volume
  std::chrono::milliseconds longest_force_pause{
      60'000};  // chosen: an application in a loop gets the board once a minute
  // How long a session without a connection waits to be resumed while nobody else wants the board; 0 = it ends.
  std::chrono::milliseconds resume_limit{10'000};  // chosen: a network that comes back, not one that is gone
  // What a session may hold for its client: results that were not waited or polled for, frames whose credit has not returned.
  std::uint64_t max_held_bytes = std::uint64_t{1} << 30;  // chosen: 32 million rays
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  // For an owner of `slot` that speaks `theirs`. `token` names the session. All references must outlive it.
  Session(const Connection::Executor& executor, BoardSlot& slot, const BusOptions& options, std::uint64_t token,
          const wire::VersionInfo& agreed, const wire::VersionInfo& theirs);

  bool ended() const { return stopped_; }
  bool serves(const BoardSlot& slot) const { return &slot_ == &slot; }

  // Why a client that says `theirs` can't go on with this session; empty if it can.
  std::string resume_fault(const wire::VersionInfo& theirs) const;
  // Before attach(): has a board built if the slot has none. Returns why there is none, or why the session has ended meanwhile.
  awaitable<std::string> prepare();
  // Answers the version frame `id` of a client that opens or resumes this session, and goes on over its connection.
  void attach(std::shared_ptr<Connection> connection, std::uint32_t id, const wire::VersionInfo& theirs);

  // Works until the session has ended; on return the board is free again. `can_resume`: a broken connection is not the end.
  awaitable<void> run(bool can_resume);

  // Ends the session, with a last word to the client. On the io thread, at any time.
  void end(wire::ErrorCode error, std::string text) { fail({error, 0, std::move(text)}); }

 private:
  struct Frame : Connection::Frame {
    std::optional<MemoryError> memory_error;  // of the fault plan
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
  // Of a kCheckpoint frame; the step is carried out on the compute thread.
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
  awaitable<std::exception_ptr> run_on_compute(std::function<void()> job, bool shows_progress,
                                               std::chrono::milliseconds limit = std::chrono::milliseconds{0});
  void note(AuditEvent event, const std::string& what) const {
    if (options_.audit != nullptr) options_.audit->note(event, peer_, fmt::format("board {}: {}", slot_.index(), what));
  }

  awaitable<void> give_board_back();
  void end_for_its_time(std::chrono::milliseconds limit);
  // Shorter if the session ends.
  awaitable<void> pause(std::chrono::microseconds duration);
  void lose(const Connected& connection, const std::optional<LastWord>& word);
  // What no client should bring about: no memory left, or a fault of ours.
  void fail(const std::exception& error);
  // The first fault is the one that the client hears of.
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
  bool is_private_ = false;  // the board's process is the client's own
  bool has_worked_ = false;  // the board has done something in this session
  std::string checkpoint_;   // the buffer of kCheckpoint frames

  Connected connection_;  // none while the client is away
  std::string peer_;      // who has, or had, the latest
  wire::ReliableWindow window_;
  std::uint32_t judged_ = 0;  // the last number that the fault plan has had its say about

  std::uint64_t held_bytes_ = 0;  // by the board, after the latest transaction

  std::deque<Frame> inbox_;
  Progress progress_;
  bool job_done_ = false;
  bool delivering_ = false;  // a frame has its number and waits to be sent, by the fault plan
  bool stopped_ = false;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();

  asio::steady_timer wake_;     // the worker sleeps on it; whoever has news cancels it
  asio::steady_timer absence_;  // the client's
};

}  // namespace gicube::emu

// One connection of the data plane, from its handshake to its last word.
//
// The reader takes frames off the socket into an inbox that the granted credits bound. The worker takes them out one by
// one, has the board carry them out on its compute thread, and sends what comes of it as far as the client's credits
// reach. Everything but Board::transact runs on the server's io thread, so nothing here is locked.
//
// A fault of the client ends its session: the last frame is kVersion | kResponse, which costs no credit, with the id of
// the frame at fault, an error code and its text. However a session ends, the board is reset before the next one.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>  // Boost 1.74's awaitable.hpp uses std::exchange without it
#include <vector>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>

#include "board_slot.h"
#include "gicube/wire/credits.h"
#include "gicube/wire/frame.h"

namespace gicube::emu {

// What the board says of itself in the handshake.
wire::VersionInfo board_version();

struct BusOptions {
  wire::VersionInfo version = board_version();
  std::chrono::milliseconds handshake_deadline{5000};  // chosen: a person's patience
  std::chrono::milliseconds progress_interval{100};    // chosen: as often as a progress bar is read
  std::size_t max_unowned = 32;                        // chosen: connections that own no board (yet)
  // Commands whose completions the client has not waited or polled for: their results stay in memory until then.
  std::uint64_t max_unclaimed_bytes = std::uint64_t{1} << 30;  // chosen: 32 million rays
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  using Socket = boost::asio::generic::stream_protocol::socket;

  // `unowned` counts the connections of the server that own no board. Both references must outlive the session.
  Session(Socket socket, BoardSlot& slot, const BusOptions& options, std::size_t& unowned);
  ~Session();

  // Serves the connection to its end; on return the board is free again and the socket closed.
  boost::asio::awaitable<void> run();

  // Ends the session, with a last word to the client. On the io thread, at any time.
  void end(wire::ErrorCode error, std::string text);

 private:
  struct Frame {
    wire::FrameHeader header;
    std::vector<std::uint8_t> payload;
    std::optional<MemoryError> memory_error{};  // comes over the board before the frame is carried out
  };
  struct LastWord {
    wire::ErrorCode error;
    std::uint32_t id;
    std::string text;
  };

  boost::asio::awaitable<bool> handshake();
  boost::asio::awaitable<std::optional<Frame>> read_version();
  boost::asio::awaitable<bool> claim_board(std::uint32_t id);
  void agree_on(const wire::VersionInfo& agreed, const wire::VersionInfo& theirs);
  void watch_handshake();

  static boost::asio::awaitable<void> read_frames(std::shared_ptr<Session> self);
  boost::asio::awaitable<bool> read_frame();
  bool admit(const wire::FrameHeader& header);
  bool take_credit(const wire::FrameHeader& header);

  boost::asio::awaitable<void> work();
  bool book_command(const wire::FrameHeader& header);
  void settle_command(std::uint32_t ticket);
  boost::asio::awaitable<Outcome> transact(const Frame& frame);
  boost::asio::awaitable<void> send_outcome(const wire::FrameHeader& request, Outcome outcome);
  boost::asio::awaitable<void> send_progress();
  boost::asio::awaitable<void> return_credit();
  boost::asio::awaitable<bool> send(wire::FrameHeader header, std::vector<std::uint8_t> payload);
  boost::asio::awaitable<bool> write(wire::FrameHeader header, std::vector<std::uint8_t> payload);

  // What the board's fault plan does to the messages of both directions (session_faults.cpp).
  boost::asio::awaitable<bool> arrives(Frame& frame);
  boost::asio::awaitable<bool> write_message(wire::FrameHeader header, std::vector<std::uint8_t> payload);
  boost::asio::awaitable<void> pause(std::chrono::microseconds time);
  boost::asio::awaitable<void> swallow();
  void cut();

  boost::asio::awaitable<std::exception_ptr> run_on_compute(std::function<void()> job, bool shows_progress);

  boost::asio::awaitable<void> give_board_back();
  boost::asio::awaitable<void> say_goodbye();
  boost::asio::awaitable<void> wait(std::chrono::milliseconds limit);
  boost::asio::awaitable<boost::system::error_code> read_exactly(std::span<std::uint8_t> bytes);
  void fail(wire::ErrorCode error, std::uint32_t id, std::string text);
  void stop();
  void close_after_linger();
  void count_as_owned();

  Socket socket_;
  BoardSlot& slot_;
  const BusOptions& options_;
  std::size_t& unowned_;
  bool is_unowned_ = true;

  wire::VersionInfo agreed_;
  std::optional<wire::SendCredits> send_credits_;
  std::optional<wire::ReceiveCredits> receive_credits_;
  std::uint32_t unreturned_slots_ = 0;  // of ours: consumed, and the client does not know yet
  std::uint64_t unreturned_bytes_ = 0;
  std::uint32_t owed_slots_ = 0;  // of the client's: used by us and not yet handed back
  std::uint64_t owed_bytes_ = 0;
  std::uint32_t sent_ = 0;  // sequence numbers of the last frames sent and taken
  std::uint32_t taken_ = 0;
  std::uint32_t asked_ = 0;                   // last frame of the client that the fault plan was asked about
  bool is_mute_ = false;                      // by the fault plan: nothing passes until the connection ends
  std::optional<std::uint32_t> bit_to_flip_;  // of the next frame that is written

  std::unordered_map<std::uint32_t, std::uint64_t> unclaimed_;  // ticket -> bytes
  std::uint64_t unclaimed_bytes_ = 0;

  std::deque<Frame> inbox_;
  Work work_;
  bool job_done_ = false;
  bool writing_ = false;
  bool reading_ = false;  // read_frames() has not returned
  bool stopped_ = false;
  std::optional<LastWord> last_word_;

  boost::asio::steady_timer wake_;      // the worker sleeps on it; whoever has news cancels it
  boost::asio::steady_timer deadline_;  // of the handshake, then of the goodbye
};

}  // namespace gicube::emu

// One socket of the data plane, independent of sessions: receives complete, undamaged frames, and sends frames.
//
// Queued frames are sent in as few writes as possible, without copying payloads. Only for the server's io thread.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coroutines.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/reliable_window.h"
#include "tls.h"

namespace gicube::emu {

struct TlsStream;

// Final message to a client before its connection is closed: a frame kVersion | kResponse with the id of the faulty
// frame.
struct LastWord {
  wire::ErrorCode error{};
  std::uint32_t id = 0;
  std::string text;
};

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Socket = asio::generic::stream_protocol::socket;
  using Executor = Socket::executor_type;

  // `tls`: null for plain TCP; must outlive this object.
  explicit Connection(Socket socket, Tls* tls = nullptr);
  ~Connection();

  struct Frame {
    wire::FrameHeader header;
    std::vector<std::uint8_t> payload;
  };
  // If both are empty, the connection has ended.
  struct Incoming {
    std::optional<Frame> frame;
    std::optional<LastWord> fault;  // not a frame, too large or damaged: the rest of the stream is not usable
  };
  // Only one reader at a time.
  awaitable<Incoming> read(std::uint32_t max_payload);

  // Queues a frame and sets `size` and `checksum`. With `flipped_bit`, it is sent damaged.
  void send(wire::FrameHeader header, wire::Payload payload, std::optional<std::uint32_t> flipped_bit = std::nullopt);
  bool idle() const { return queued_.empty() && !writing_; }
  std::size_t waiting_frames() const { return queued_.size() + in_flight_.size(); }

  // Sends the reason, and closes when the client has closed or after a timeout. Closing with unread input could lose
  // the message.
  void refuse(const LastWord& word);
  void close() {
    closing_ = true;
    queued_.clear();
    linger_.cancel();
    error_code ignored;
    socket_.close(ignored);
  }
  // Blocks all traffic in both directions until the client closes.
  void hang() { hanging_ = true; }
  bool is_open() const { return !closing_; }
  // Reads and discards input until the client closes, then closes too.
  awaitable<void> drop_input();
  // Returns true if the client has closed its end. Does not consume input.
  bool client_has_left();

  Executor executor() { return socket_.get_executor(); }
  // The peer, for example "process 1234" or "127.0.0.1:5678"; and its process or machine, for example "127.0.0.1".
  const std::string& peer() const { return peer_.name; }
  const std::string& host() const { return peer_.host; }

 private:
  struct Peer {
    std::string name, host;
  };
  struct Outgoing {
    std::array<std::uint8_t, wire::kFrameHeaderBytes> header{};
    wire::Payload payload;
  };

  awaitable<bool> secure();
  static Peer peer_of(Socket& socket);
  awaitable<error_code> read_exactly(std::span<std::uint8_t> bytes);
  awaitable<Incoming> read_one(std::uint32_t max_payload);
  static awaitable<void> write_queued(std::shared_ptr<Connection> self);

  Socket socket_;
  std::unique_ptr<TlsStream> tls_;  // null: plain TCP
  asio::steady_timer linger_;
  const Peer peer_;
  std::deque<Outgoing> queued_;
  std::deque<Outgoing> in_flight_;
  bool writing_ = false;
  bool reading_ = false;
  bool closing_ = false;  // the final message is queued, or the socket is closed
  bool hanging_ = false;
  bool ended_ = false;  // the client sends nothing more
};

}  // namespace gicube::emu

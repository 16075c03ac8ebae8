// One socket of the data plane, whatever session it serves: whole, undamaged frames in, frames out.
//
// What is queued goes out in as few writes as the socket allows, payloads uncopied. Only for the server's io thread.
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

// What a client is told before its connection is closed: a frame kVersion | kResponse with the id of the frame at fault.
struct LastWord {
  wire::ErrorCode error{};
  std::uint32_t id = 0;
  std::string text;
};

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Socket = asio::generic::stream_protocol::socket;
  using Executor = Socket::executor_type;

  // `tls`: null for plain bytes; must outlive this.
  explicit Connection(Socket socket, Tls* tls = nullptr);
  ~Connection();

  struct Frame {
    wire::FrameHeader header;
    std::vector<std::uint8_t> payload;
  };
  // Neither of both: the connection has ended.
  struct Incoming {
    std::optional<Frame> frame;
    std::optional<LastWord> fault;  // what came is no frame, too large or damaged: nothing after it can be read
  };
  // One reader at a time.
  awaitable<Incoming> read(std::uint32_t max_payload);

  // Queues a frame; `size` and `checksum` are set. With `flipped_bit` it is damaged on its way.
  void send(wire::FrameHeader header, wire::Payload payload, std::optional<std::uint32_t> flipped_bit = std::nullopt);
  bool idle() const { return queued_.empty() && !writing_; }
  std::size_t waiting_frames() const { return queued_.size() + in_flight_.size(); }

  // Says why, and closes once the client has closed or its time is up: closing on unread bytes could lose the last word.
  void refuse(const LastWord& word);
  void close() {
    closing_ = true;
    queued_.clear();
    linger_.cancel();
    error_code ignored;
    socket_.close(ignored);
  }
  // From now on nothing passes any more, in either direction, until the client closes.
  void hang() { hanging_ = true; }
  bool is_open() const { return !closing_; }
  // Reads and forgets until the client closes, then closes too.
  awaitable<void> drop_input();
  // True if the client has closed its end: found without reading.
  bool client_has_left();

  Executor executor() { return socket_.get_executor(); }
  // Who is at the other end, as "process 1234" or "127.0.0.1:5678"; and on which machine or in which process, as "127.0.0.1".
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
  std::unique_ptr<TlsStream> tls_;  // null: plain
  asio::steady_timer linger_;
  const Peer peer_;
  std::deque<Outgoing> queued_;
  std::deque<Outgoing> in_flight_;
  bool writing_ = false;
  bool reading_ = false;
  bool closing_ = false;  // the last word is queued, or the socket is closed
  bool hanging_ = false;
  bool ended_ = false;  // the client sends no more
};

}  // namespace gicube::emu

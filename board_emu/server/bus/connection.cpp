#include "connection.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>

#include "gicube/wire/checksum.h"
#include "server/faults/fault_point.h"

namespace gicube::emu {

using wire::ErrorCode;
using wire::FrameHeader;

struct TlsStream {
  TlsStream(Connection::Socket& socket, Tls& tls) : stream(socket, tls) {}

  asio::ssl::stream<Connection::Socket&> stream;
  bool is_up = false;  // the TLS handshake has succeeded
};

namespace {

constexpr std::chrono::seconds kLinger{1};  // chosen: time for the client to read the final message

Connection::Incoming damaged_frame(std::uint32_t id, std::string text) {
  Connection::Incoming incoming;
  incoming.fault = LastWord{ErrorCode::kCorrupted, id, std::move(text)};
  return incoming;
}

}  // namespace

Connection::Connection(Socket socket, Tls* tls)
    : socket_(std::move(socket)),
      tls_(tls != nullptr ? std::make_unique<TlsStream>(socket_, *tls) : nullptr),
      linger_(socket_.get_executor()),
      peer_(peer_of(socket_)) {}

Connection::~Connection() = default;

// Returns false if the client does not use TLS, or not a supported version.
awaitable<bool> Connection::secure() {
  if (!tls_ || tls_->is_up) co_return true;
  error_code error;
  co_await tls_->stream.async_handshake(asio::ssl::stream_base::server, into(error));
  tls_->is_up = !error;
  ended_ = ended_ || error;
  co_return !error;
}

Connection::Peer Connection::peer_of(Socket& socket) {
  const Peer nobody{"a client", "a client"};
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getpeername(socket.native_handle(), reinterpret_cast<sockaddr*>(&address), &size) != 0) return nobody;
  if (address.ss_family == AF_UNIX) {
    ucred who{};
    socklen_t who_size = sizeof who;
    const bool known = ::getsockopt(socket.native_handle(), SOL_SOCKET, SO_PEERCRED, &who, &who_size) == 0;
    if (!known || who.pid <= 0) return nobody;
    const std::string process = fmt::format("process {}", who.pid);
    return {process, process};
  }
  asio::ip::tcp::endpoint endpoint;
  if (size > endpoint.capacity()) return nobody;
  std::copy_n(reinterpret_cast<const char*>(&address), size, reinterpret_cast<char*>(endpoint.data()));
  endpoint.resize(size);
  const std::string host = endpoint.address().to_string();
  return {fmt::format("{}:{}", host, endpoint.port()), host};
}

awaitable<error_code> Connection::read_exactly(std::span<std::uint8_t> bytes) {
  error_code error;
  const auto buffer = asio::buffer(bytes.data(), bytes.size());
  if (tls_) {
    co_await asio::async_read(tls_->stream, buffer, into(error));
  } else {
    co_await asio::async_read(socket_, buffer, into(error));
  }
  ended_ = ended_ || error;
  co_return error;
}

awaitable<Connection::Incoming> Connection::read(std::uint32_t max_payload) {
  if (closing_) co_return Incoming{};
  reading_ = true;
  Incoming incoming;
  const bool is_up = co_await secure();
  if (is_up) incoming = co_await read_one(max_payload);
  reading_ = false;
  if (hanging_ || closing_) {
    co_await drop_input();
    co_return Incoming{};
  }
  co_return incoming;
}

awaitable<Connection::Incoming> Connection::read_one(std::uint32_t max_payload) {
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  const error_code header_error = co_await read_exactly(bytes);
  if (header_error) co_return Incoming{};
  const std::optional<FrameHeader> header = wire::decode_frame_header(bytes);
  if (!header) {
    co_return damaged_frame(
        0, fmt::format("expected a frame header (magic 0x{:08x}), got 0x{:08x} and type {}", wire::kFrameMagic,
                       wire::load<std::uint32_t>(bytes, 0), wire::load<std::uint16_t>(bytes, 4)));
  }
  if (header->size > max_payload) {
    Incoming incoming =
        damaged_frame(header->id, fmt::format("expected at most {} payload bytes, got {}", max_payload, header->size));
    incoming.fault->error = ErrorCode::kTooLarge;
    co_return incoming;
  }
  Frame frame{*header, std::vector<std::uint8_t>(header->size)};
  if (header->size > 0) {
    const error_code payload_error = co_await read_exactly(frame.payload);
    if (payload_error) co_return Incoming{};
  }
  const std::uint32_t checksum = wire::frame_checksum(bytes, frame.payload);
  if (checksum != header->checksum) {
    co_return damaged_frame(header->id,
                            fmt::format("expected the checksum 0x{:08x}, got 0x{:08x}", checksum, header->checksum));
  }
  Incoming incoming;
  incoming.frame = std::move(frame);
  co_return incoming;
}

void Connection::send(FrameHeader header, wire::Payload payload, std::optional<std::uint32_t> flipped_bit) {
  if (closing_ || hanging_) return;
  header.size = static_cast<std::uint32_t>(payload->size());
  Outgoing frame;
  wire::encode_sealed(header, *payload, frame.header);
  if (flipped_bit) {
    std::vector<std::uint8_t> damaged = *payload;
    flip_bit(*flipped_bit, frame.header, damaged);
    payload = wire::share(std::move(damaged));
  }
  frame.payload = std::move(payload);
  queued_.push_back(std::move(frame));
  if (writing_) return;
  writing_ = true;
  asio::co_spawn(executor(), write_queued(shared_from_this()), asio::detached);
}

awaitable<void> Connection::write_queued(std::shared_ptr<Connection> self) {
  constexpr std::size_t kMaxFrames = 64;  // chosen: two buffers each; the system takes 1024
  while (!self->queued_.empty()) {
    std::vector<asio::const_buffer> buffers;
    while (!self->queued_.empty() && self->in_flight_.size() < kMaxFrames) {
      Outgoing& frame = self->in_flight_.emplace_back(std::move(self->queued_.front()));
      self->queued_.pop_front();
      buffers.push_back(asio::buffer(frame.header));
      if (!frame.payload->empty()) buffers.push_back(asio::buffer(*frame.payload));
    }
    error_code error;
    if (self->tls_) {
      co_await asio::async_write(self->tls_->stream, buffers, into(error));
    } else {
      co_await asio::async_write(self->socket_, buffers, into(error));
    }
    self->in_flight_.clear();
    if (error) self->close();  // the reader detects the end
  }
  self->writing_ = false;
  error_code ignored;
  if (self->closing_ && self->socket_.is_open()) self->socket_.shutdown(Socket::shutdown_send, ignored);
}

void Connection::refuse(const LastWord& word) {
  if (closing_) return;
  if (tls_ && !tls_->is_up) return close();  // not possible before the handshake
  FrameHeader header{wire::FrameType::kVersion, wire::kResponse, word.id};
  header.error = word.error;
  send(header, wire::share({word.text.begin(), word.text.end()}));
  closing_ = true;
  linger_.expires_after(kLinger);
  linger_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled) self->close();
  });
  if (reading_) return;  // the reader then discards further input
  asio::co_spawn(
      executor(), [self = shared_from_this()]() { return self->drop_input(); }, asio::detached);
}

awaitable<void> Connection::drop_input() {
  const auto self = shared_from_this();
  std::vector<std::uint8_t> scrap(std::size_t{16} << 10);
  // Asio never returns if it is asked again after the end.
  while (!ended_ && socket_.is_open()) {
    error_code error;
    co_await socket_.async_read_some(asio::buffer(scrap), into(error));
    ended_ = ended_ || error;
  }
  linger_.cancel();
  close();
}

bool Connection::client_has_left() {
  if (!socket_.is_open()) return true;
  char byte = 0;
  return ::recv(socket_.native_handle(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

}  // namespace gicube::emu

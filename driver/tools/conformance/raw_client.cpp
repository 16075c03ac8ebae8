#include "raw_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <stdexcept>

#include "gicube/wire/checksum.h"

namespace gicube::reference {

using wire::FrameHeader;
using wire::FrameType;

namespace {

int connect_to(const sockaddr* address, socklen_t size, const std::string& name, const sockaddr* source = nullptr) {
  const int fd = ::socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool is_bound = source == nullptr || ::bind(fd, source, size) == 0;
  if (fd < 0 || !is_bound || ::connect(fd, address, size) != 0) {
    if (fd >= 0) ::close(fd);
    throw std::runtime_error("cannot connect to " + name);
  }
  return fd;
}

}  // namespace

RawClient RawClient::connect_unix(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  return RawClient(connect_to(reinterpret_cast<const sockaddr*>(&address), sizeof address, path));
}

RawClient RawClient::connect_tcp(std::uint16_t port, const char* source) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  sockaddr_in from{};
  from.sin_family = AF_INET;
  ::inet_pton(AF_INET, source, &from.sin_addr);
  const int fd = connect_to(reinterpret_cast<const sockaddr*>(&address), sizeof address, std::to_string(port),
                            reinterpret_cast<const sockaddr*>(&from));
  const int on = 1;
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return RawClient(fd);
}

RawClient::RawClient(int fd) : fd_(fd) { limit_silence(std::chrono::seconds(60)); }

void RawClient::limit_silence(std::chrono::milliseconds most) {
  const timeval silence{most.count() / 1000, most.count() % 1000 * 1000};
  ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &silence, sizeof silence);
}

void RawClient::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

void RawClient::end_sending() { ::shutdown(fd_, SHUT_WR); }

bool RawClient::send_bytes(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
  return true;
}

bool RawClient::send(FrameHeader header, std::span<const std::uint8_t> payload) {
  header.size = static_cast<std::uint32_t>(payload.size());
  if (!wire::is_free(header.type)) header.sequence = ++sent_;
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  wire::encode_sealed(header, payload, bytes);
  return send_bytes(bytes) && send_bytes(payload);
}

bool RawClient::send(FrameType type, std::uint32_t id, std::uint16_t flags, std::span<const std::uint8_t> payload) {
  FrameHeader header;
  header.type = type;
  header.id = id;
  header.flags = flags;
  return send(header, payload);
}

std::size_t RawClient::read_fully(std::span<std::uint8_t> bytes) {
  std::size_t at = 0;
  while (at < bytes.size()) {
    const ssize_t got = ::recv(fd_, bytes.data() + at, bytes.size() - at, 0);
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) throw std::runtime_error("the board is silent");
    if (got <= 0) break;
    at += static_cast<std::size_t>(got);
  }
  return at;
}

std::optional<RawFrame> RawClient::receive() {
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  if (read_fully(bytes) < bytes.size()) return std::nullopt;
  const auto header = wire::decode_frame_header(bytes);
  if (!header) throw std::runtime_error("the board sent something that is no frame");
  RawFrame frame{*header, std::vector<std::uint8_t>(header->size)};
  if (read_fully(frame.payload) < frame.payload.size()) return std::nullopt;
  if (wire::frame_checksum(bytes, frame.payload) != header->checksum)
    throw std::runtime_error("the board sent a frame with a wrong checksum");
  return frame;
}

std::optional<RawFrame> RawClient::receive_answer() {
  for (;;) {
    std::optional<RawFrame> frame = receive();
    const bool is_aside =
        frame && (frame->header.type == FrameType::kCredit || frame->header.type == FrameType::kProgress);
    if (!is_aside) return frame;
  }
}

std::optional<RawFrame> RawClient::handshake(const wire::VersionInfo& mine, const std::string& token) {
  std::vector<std::uint8_t> payload(wire::kVersionBytes);
  wire::encode(mine, payload);
  payload.insert(payload.end(), token.begin(), token.end());
  send(FrameType::kVersion, 0, 0, payload);
  return receive();
}

std::optional<RawFrame> RawClient::call(FrameType type, std::uint32_t id, std::span<const std::uint8_t> payload) {
  send(type, id, 0, payload);
  return receive_answer();
}

void RawClient::write_register(std::uint32_t offset, std::uint32_t value) {
  std::array<std::uint8_t, 8> payload{};
  wire::store(std::span<std::uint8_t>(payload), 0, offset);
  wire::store(std::span<std::uint8_t>(payload), 4, value);
  send(FrameType::kRegisterWrite, 0, wire::kPosted, payload);
}

std::uint64_t RawClient::read_register(std::uint32_t offset) {
  std::array<std::uint8_t, 4> payload{};
  wire::store(std::span<std::uint8_t>(payload), 0, offset);
  const auto answer = call(FrameType::kRegisterRead, 77, payload);
  const bool is_good = answer && answer->header.type == FrameType::kRegisterRead && answer->payload.size() == 4;
  return is_good ? wire::load<std::uint32_t>(answer->payload, 0) : ~std::uint64_t{0};
}

}  // namespace gicube::reference

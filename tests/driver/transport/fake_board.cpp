#include "fake_board.h"

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <stdexcept>

#include "gicube/wire/checksum.h"
#include "unix_socket.h"

namespace gicube::reference {

FakeBoard::FakeBoard(Script script) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) throw std::runtime_error("socketpair");
  driver_end_ = Fd(ends[0]);
  board_end_ = Fd(ends[1]);
  thread_ = std::thread([this, script = std::move(script)] {
    script(*this);
    board_end_.reset();
  });
}

FakeBoard::FakeBoard(const std::string& path, Script script) {
  Fd listening(bound_socket(path, 1));
  thread_ = std::thread([this, listening = std::move(listening), script = std::move(script)] {
    board_end_ = Fd(::accept4(listening.get(), nullptr, nullptr, SOCK_CLOEXEC));
    script(*this);
    board_end_.reset();
  });
}

FakeBoard::~FakeBoard() {
  driver_end_.reset();
  thread_.join();
}

bool FakeBoard::receive_bytes(std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::recv(board_end_.get(), bytes.data(), bytes.size(), 0);
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

std::optional<Frame> FakeBoard::receive() {
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  if (!receive_bytes(bytes)) return std::nullopt;
  const auto header = wire::decode_frame_header(bytes);
  if (!header) return std::nullopt;
  const bool is_probe = header->type == wire::FrameType::kCredit && header->flags == 0;
  if (is_probe && header->size == 0) return receive();  // scripts are about other things
  Frame frame{*header, std::vector<std::uint8_t>(header->size)};
  if (!receive_bytes(frame.payload)) return std::nullopt;
  if (wire::frame_checksum(bytes, frame.payload) != header->checksum) return std::nullopt;
  return frame;
}

std::optional<Frame> FakeBoard::receive_until(wire::FrameType type) {
  for (;;) {
    auto frame = receive();
    if (!frame || frame->header.type == type) return frame;
  }
}

void FakeBoard::send_bytes(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::send(board_end_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (put <= 0) return;  // the driver has closed
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
}

void FakeBoard::send(wire::FrameHeader header, std::span<const std::uint8_t> payload) {
  header.size = static_cast<std::uint32_t>(payload.size());
  if (!wire::is_free(header.type)) header.sequence = ++sent_;
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  wire::encode_sealed(header, payload, bytes);
  send_bytes(bytes);
  send_bytes(payload);
}

void FakeBoard::respond(const Frame& request, std::uint64_t time_ps, std::span<const std::uint8_t> payload) {
  wire::FrameHeader header;
  header.type = request.header.type;
  header.flags = wire::kResponse;
  header.id = request.header.id;
  header.time_ps = time_ps;
  send(header, payload);
}

void FakeBoard::refuse(const Frame& request, wire::ErrorCode error, std::string_view text) {
  wire::FrameHeader header;
  header.type = request.header.type;
  header.flags = wire::kResponse;
  header.id = request.header.id;
  header.error = error;
  send(header, bytes_of(text));
}

void FakeBoard::complete(std::uint32_t ticket, std::uint64_t time_ps, std::span<const std::uint8_t> payload) {
  wire::FrameHeader header;
  header.type = wire::FrameType::kCompletion;
  header.id = ticket;
  header.time_ps = time_ps;
  send(header, payload);
}

void FakeBoard::progress(std::uint32_t ticket, std::uint32_t done, std::uint32_t all) {
  std::array<std::uint8_t, 8> payload{};
  wire::store(payload, 0, done);
  wire::store(payload, 4, all);
  wire::FrameHeader header;
  header.type = wire::FrameType::kProgress;
  header.id = ticket;
  send(header, payload);
}

void FakeBoard::return_credit(std::uint32_t slots, std::uint64_t bytes) {
  wire::FrameHeader header;
  header.type = wire::FrameType::kCredit;
  header.credit_slots = slots;
  header.credit_bytes = bytes;
  send(header);
}

wire::VersionInfo FakeBoard::shake_hands(const wire::VersionInfo& mine) {
  const auto hello = receive();
  if (!hello || hello->payload.size() != wire::kVersionBytes) return {};
  std::array<std::uint8_t, wire::kVersionBytes> payload{};
  encode(mine, payload);
  respond(*hello, 0, payload);
  return wire::decode<wire::VersionInfo>(hello->payload);
}

void FakeBoard::drain() {
  while (receive()) {
  }
}

bool FakeBoard::readable_within(int milliseconds) const {
  pollfd item{board_end_.get(), POLLIN, 0};
  return ::poll(&item, 1, milliseconds) > 0;
}

std::vector<std::uint8_t> bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

}  // namespace gicube::reference

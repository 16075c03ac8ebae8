#include "bus_client.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "gicube/wire/checksum.h"

namespace gicube::replay {
namespace {

using wire::FrameHeader;
using wire::FrameType;

std::vector<std::uint8_t> sealed(FrameHeader header, const std::vector<std::uint8_t>& payload) {
  header.size = static_cast<std::uint32_t>(payload.size());
  std::vector<std::uint8_t> bytes(wire::kFrameHeaderBytes);
  wire::encode_sealed(header, payload, std::span(bytes).first<wire::kFrameHeaderBytes>());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

std::string text_of(const std::vector<std::uint8_t>& payload) { return {payload.begin(), payload.end()}; }

}  // namespace

BusClient::BusClient(Fd socket, std::uint32_t largest_payload, std::chrono::milliseconds watchdog, OnFrame on_frame)
    : socket_(std::move(socket)), watchdog_(watchdog), on_frame_(std::move(on_frame)) {
  shake_hands(largest_payload);
}

void BusClient::shake_hands(std::uint32_t largest_payload) {
  wire::VersionInfo mine;
  mine.max_payload_bytes = std::max(mine.max_payload_bytes, largest_payload);
  mine.window_bytes = std::max<std::uint64_t>(mine.window_bytes, 4 * std::uint64_t{mine.max_payload_bytes});
  mine.capabilities = wire::kFunctionalLevel | wire::kApproximateLevel | wire::kCycleLevel | wire::kHostRays;
  std::vector<std::uint8_t> payload(wire::kVersionBytes);
  wire::encode(mine, std::span(payload).first<wire::kVersionBytes>());
  FrameHeader header;
  header.type = FrameType::kVersion;
  write(sealed(header, payload));
  const Frame answer = receive();
  if (answer.header.type != FrameType::kVersion) throw BusError("no GI-Cube board answers there");
  if (answer.header.error != wire::ErrorCode::kNone) throw BusError(text_of(answer.payload));
  if (answer.payload.size() < wire::kVersionBytes) throw BusError("the board's version is cut short");
  const auto theirs = wire::decode_version(std::span(answer.payload).first<wire::kVersionBytes>());
  const auto agreed = wire::agree(mine, theirs);
  if (!agreed) throw BusError(fmt::format("the board speaks version {}.{}", theirs.major, theirs.minor));
  max_payload_ = agreed->max_payload_bytes;
  send_credits_ = wire::SendCredits(theirs.window_slots, theirs.window_bytes);
}

void BusClient::send(FrameHeader header, const std::vector<std::uint8_t>& payload) {
  if (payload.size() > max_payload_) {
    throw BusError(fmt::format("a frame of {} bytes, the board takes {}", payload.size(), max_payload_));
  }
  while (!send_credits_.can_send(payload.size())) take(receive());
  send_credits_.take(payload.size());
  header.sequence = ++sent_;
  header.credit_slots = std::exchange(owed_slots_, 0);
  header.credit_bytes = std::exchange(owed_bytes_, 0);
  write(sealed(header, payload));
}

void BusClient::await_answer(std::uint32_t id) {
  for (answered_ = 0; answered_ != id;) take(receive());
}

void BusClient::take(const Frame& frame) {
  const FrameHeader& header = frame.header;
  if (header.type == FrameType::kVersion) throw BusError("the board ended the session: " + text_of(frame.payload));
  send_credits_.give_back(header.credit_slots, header.credit_bytes);
  if (wire::is_free(header.type)) return;
  on_frame_(frame);
  if ((header.flags & wire::kResponse) != 0) answered_ = header.id;
  ++owed_slots_;
  owed_bytes_ += frame.payload.size();
  // By itself when the board may be waiting for it.
  if (owed_slots_ < 16 && owed_bytes_ < max_payload_) return;
  FrameHeader credit;
  credit.type = FrameType::kCredit;
  credit.flags = wire::kPosted;
  credit.id = sent_;
  credit.credit_slots = std::exchange(owed_slots_, 0);
  credit.credit_bytes = std::exchange(owed_bytes_, 0);
  write(sealed(credit, {}));
}

BusClient::Frame BusClient::receive() {
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  read(bytes.data(), bytes.size());
  const auto header = wire::decode_frame_header(bytes);
  const std::uint32_t limit = std::max(max_payload_, wire::kMaxHandshakePayload);
  if (!header || header->size > limit) throw BusError("the board sent something that is no frame");
  Frame frame{*header, std::vector<std::uint8_t>(header->size)};
  read(frame.payload.data(), frame.payload.size());
  if (wire::frame_checksum(bytes, frame.payload) != header->checksum) {
    throw BusError("a frame of the board has a wrong checksum");
  }
  return frame;
}

// The board reads what there is credit for even while it writes, so writing never waits for our reading.
void BusClient::write(const std::vector<std::uint8_t>& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t count = ::send(socket_.get(), bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw BusError(fmt::format("the board closed the connection: {}", std::strerror(errno)));
    at += static_cast<std::size_t>(count);
  }
}

void BusClient::read(std::uint8_t* bytes, std::size_t count) {
  while (count > 0) {
    pollfd ready{socket_.get(), POLLIN, 0};
    const int found = ::poll(&ready, 1, watchdog_.count() == 0 ? -1 : static_cast<int>(watchdog_.count()));
    if (found == 0) throw BusError(fmt::format("no answer of the board within {} ms", watchdog_.count()));
    const ssize_t got = ::recv(socket_.get(), bytes, count, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw BusError("the board closed the connection");
    bytes += got;
    count -= static_cast<std::size_t>(got);
  }
}

}  // namespace gicube::replay

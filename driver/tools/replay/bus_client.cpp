#include "bus_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace gicube::replay {
namespace {

using wire::FrameHeader;
using wire::FrameType;

std::string text_of(const std::vector<std::uint8_t>& payload) { return {payload.begin(), payload.end()}; }

wire::VersionInfo version_for(std::uint32_t largest_payload) {
  wire::VersionInfo mine;
  mine.max_payload_bytes = std::max(mine.max_payload_bytes, largest_payload);
  mine.window_bytes = std::max<std::uint64_t>(mine.window_bytes, 4 * std::uint64_t{mine.max_payload_bytes});
  mine.capabilities = wire::kFunctionalLevel | wire::kApproximateLevel | wire::kCycleLevel | wire::kHostRays;
  return mine;
}

}  // namespace

BusClient::BusClient(Fd socket, std::uint32_t largest_payload, std::chrono::milliseconds watchdog, OnFrame on_frame)
    : watchdog_(watchdog),
      on_frame_(std::move(on_frame)),
      mine_(version_for(largest_payload)),
      window_(mine_),
      stream_(std::move(socket), *this) {
  stream_.start();
  shake_hands();
}

void BusClient::shake_hands() {
  stream_.send(FrameHeader{FrameType::kVersion}, wire::version_payload(mine_));
  const Frame answer = receive();
  if (answer.header.type != FrameType::kVersion) throw BusError("no GI-Cube board answers there");
  if (answer.header.error != wire::ErrorCode::kNone) throw BusError(text_of(answer.payload));
  if (answer.payload.size() < wire::kVersionBytes) throw BusError("the board's version is cut short");
  const auto theirs = wire::decode<wire::VersionInfo>(answer.payload);
  const auto agreed = wire::agree(mine_, theirs);
  if (!agreed) throw BusError(fmt::format("the board speaks version {}.{}", theirs.major, theirs.minor));
  max_payload_ = agreed->max_payload_bytes;
  window_.open(theirs);
}

void BusClient::send(const FrameHeader& header, const std::vector<std::uint8_t>& payload) {
  if (payload.size() > max_payload_) {
    throw BusError(fmt::format("a frame of {} bytes, the board takes {}", payload.size(), max_payload_));
  }
  while (!window_.can_send(payload.size())) take(receive());
  wire::ReliableWindow::Sent frame = window_.keep(header, wire::share(payload));
  window_.put_credit(frame.header);
  stream_.send(frame.header, std::move(frame.payload));
}

void BusClient::await_answer(std::uint32_t id) {
  for (answered_ = 0; answered_ != id;) take(receive());
}

void BusClient::take(const Frame& frame) {
  const FrameHeader& header = frame.header;
  if (header.type == FrameType::kVersion) throw BusError("the board ended the session: " + text_of(frame.payload));
  if (!window_.take_credit(header)) throw BusError("the board handed back credit that it never took");
  if (wire::is_free(header.type)) return;
  if (!window_.accept(frame.payload.size())) throw BusError("the board sent more than it had credit for");
  on_frame_(frame);
  if ((header.flags & wire::kResponse) != 0) answered_ = header.id;
  window_.consume(frame.payload.size());
  if (window_.credit_is_due()) stream_.send(window_.credit_frame(wire::kPosted), wire::no_payload());
}

BusClient::Frame BusClient::receive() {
  std::unique_lock lock(mutex_);
  const auto has_news = [this] { return !arrived_.empty() || ended_; };
  if (watchdog_.count() == 0) {
    changed_.wait(lock, has_news);
  } else if (!changed_.wait_for(lock, watchdog_, has_news)) {
    throw BusError(fmt::format("no answer of the board within {} ms", watchdog_.count()));
  }
  if (arrived_.empty()) throw BusError(*ended_);
  Frame frame = std::move(arrived_.front());
  arrived_.pop_front();
  return frame;
}

StreamFault BusClient::check_header(const FrameHeader& header) {
  if (header.size <= mine_.max_payload_bytes) return {};
  return {"the board sent something that is no frame"};
}

StreamFault BusClient::take_frame(const FrameHeader& header, std::vector<std::uint8_t> payload) {
  const std::lock_guard lock(mutex_);
  arrived_.push_back({header, std::move(payload)});
  changed_.notify_all();
  return {};
}

void BusClient::stream_ended(const StreamFault& reason) {
  const std::lock_guard lock(mutex_);
  ended_ = reason.text;
  changed_.notify_all();
}

}  // namespace gicube::replay

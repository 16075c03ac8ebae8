// The fault plan's part in a session: it stands between the socket and everything else, so that both sides meet its faults
// as they would meet those of a link.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "gicube/wire/checksum.h"
#include "session.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace gicube::emu {

namespace asio = boost::asio;
using asio::awaitable;
using boost::system::error_code;

namespace {

constexpr std::chrono::milliseconds kLongestNap{10};  // chosen: how late a paused session notices its end

}  // namespace

// A frame that is the next in order. False if it has been lost, and with it perhaps the connection.
awaitable<bool> Session::arrives(Frame& frame) {
  const bool is_new = wire::sequence_step(asked_, frame.header.sequence) > 0;
  if (!is_new) co_return true;
  asked_ = frame.header.sequence;
  const FaultAction action = slot_.faults().taken(wire::kFrameHeaderBytes + frame.payload.size());
  if (!action.any()) co_return true;
  frame.memory_error = action.memory_error;
  co_await pause(action.pause);
  if (action.hang) co_await swallow();
  if (action.cut) cut();
  if (action.flipped_bit) {
    std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
    wire::encode(frame.header, bytes);
    flip_bit(*action.flipped_bit, bytes, frame.payload);
    const std::uint32_t expected = wire::frame_checksum(bytes, frame.payload);
    const auto got = wire::load<std::uint32_t>(bytes, wire::kFrameHeaderBytes - sizeof(std::uint32_t));
    fail(wire::ErrorCode::kCorrupted, frame.header.id,
         fmt::format("expected the checksum 0x{:08x}, got 0x{:08x}", expected, got));
  }
  // One that comes twice is dropped by its number the second time.
  co_return !stopped_ && !action.hang && !action.cut && !action.drop && !action.flipped_bit;
}

// A frame with the next sequence number.
awaitable<bool> Session::write_message(wire::FrameHeader header, std::vector<std::uint8_t> payload) {
  const FaultAction action = slot_.faults().sent(wire::kFrameHeaderBytes + payload.size());
  co_await pause(action.pause);
  if (action.hang) is_mute_ = true;
  if (action.cut) cut();
  if (action.cut || action.drop || stopped_) co_return !stopped_;
  if (action.twice) co_await write(header, payload);
  bit_to_flip_ = action.flipped_bit;
  const bool written = co_await write(header, std::move(payload));
  co_return written;
}

awaitable<void> Session::pause(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  asio::steady_timer timer(socket_.get_executor());
  while (!stopped_ && std::chrono::steady_clock::now() < end) {
    timer.expires_at(
        std::min<std::chrono::steady_clock::time_point>(end, std::chrono::steady_clock::now() + kLongestNap));
    error_code ignored;
    co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  }
}

// The board hangs: what comes is taken off the socket, so that the client's writing does not tell it, and that is all.
// Once the end has been read nobody may read again: the reactor would wait for another.
awaitable<void> Session::swallow() {
  is_mute_ = true;
  std::array<std::uint8_t, 4096> scrap;
  error_code ended;
  while (!ended && !stopped_) {
    co_await socket_.async_read_some(asio::buffer(scrap), asio::redirect_error(asio::use_awaitable, ended));
  }
}

// As if the line had been cut: the reader and the client find the connection ended.
void Session::cut() {
  is_mute_ = true;
  error_code ignored;
  socket_.shutdown(Socket::shutdown_both, ignored);
}

}  // namespace gicube::emu

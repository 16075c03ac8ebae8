// The owned part of a session: frames in, the board's work, frames out.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <exception>

#include "fault_point.h"
#include "gicube/wire/checksum.h"
#include "session.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

namespace gicube::emu {

namespace asio = boost::asio;
using asio::awaitable;
using boost::system::error_code;
using wire::ErrorCode;
using wire::FrameHeader;
using wire::FrameType;

namespace {

constexpr std::chrono::hours kUntilWoken{24};
constexpr std::uint64_t kCommandOverhead = 1024;  // chosen: bytes of bookkeeping for one command

enum class Manner { kNotFromHost, kPosted, kNonPosted };

Manner manner_of(FrameType type) {
  switch (type) {
    case FrameType::kCredit:
    case FrameType::kRegisterWrite:
    case FrameType::kMemoryWrite:
    case FrameType::kCommand: return Manner::kPosted;
    case FrameType::kConfigRead:
    case FrameType::kConfigWrite:
    case FrameType::kRegisterRead:
    case FrameType::kMemoryRead:
    case FrameType::kWait:
    case FrameType::kPoll:
    case FrameType::kCancel:
    case FrameType::kCounters: return Manner::kNonPosted;
    default: return Manner::kNotFromHost;
  }
}

// The length that a kMemoryRead asks for; 0 if its payload is malformed, which the board reports.
std::uint64_t requested_bytes(const FrameHeader& header, std::span<const std::uint8_t> payload) {
  if (header.type != FrameType::kMemoryRead || payload.size() != 16) return 0;
  return wire::load<std::uint64_t>(payload, 8);
}

}  // namespace

// ---- reader

awaitable<void> Session::read_frames(std::shared_ptr<Session> self) {
  try {
    bool more = true;
    while (more) more = co_await self->read_frame();
  } catch (const std::exception& error) {  // no memory for a payload
    self->fail(ErrorCode::kInternal, 0, error.what());
  }
  // Whatever still comes is dropped, so that the client can read the last word before it notices.
  std::array<std::uint8_t, 4096> scrap;
  error_code ended;
  while (self->last_word_ && !ended) {
    co_await self->socket_.async_read_some(asio::buffer(scrap), asio::redirect_error(asio::use_awaitable, ended));
  }
  self->stop();
  self->reading_ = false;
  self->wake_.cancel();
}

// False once nothing more is to be read.
awaitable<bool> Session::read_frame() {
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  const error_code header_error = co_await read_exactly(bytes);
  if (header_error || stopped_) co_return false;
  if (is_mute_) {
    co_await swallow();
    co_return false;
  }
  const std::optional<FrameHeader> header = wire::decode_frame_header(bytes);
  if (!header) {
    fail(ErrorCode::kProtocol, 0,
         fmt::format("expected a frame header (magic 0x{:08x}), got 0x{:08x} and type {}", wire::kFrameMagic,
                     wire::load<std::uint32_t>(bytes, 0), wire::load<std::uint16_t>(bytes, 4)));
    co_return false;
  }
  if (header->size > agreed_.max_payload_bytes) {
    fail(ErrorCode::kTooLarge, header->id,
         fmt::format("expected at most {} payload bytes, got {}", agreed_.max_payload_bytes, header->size));
    co_return false;
  }
  Frame frame{*header, std::vector<std::uint8_t>(header->size)};
  const error_code payload_error = co_await read_exactly(frame.payload);
  if (payload_error || stopped_) co_return false;
  if (wire::frame_checksum(bytes, frame.payload) != header->checksum) {
    fail(ErrorCode::kCorrupted, header->id,
         fmt::format("expected the checksum 0x{:08x}, got 0x{:08x}", wire::frame_checksum(bytes, frame.payload),
                     header->checksum));
    co_return false;
  }
  if (!wire::is_free(header->type)) {
    const std::int32_t step = wire::sequence_step(taken_, header->sequence);
    if (step <= 0) co_return true;  // it came twice
    if (step > 1) {
      fail(ErrorCode::kCorrupted, header->id,
           fmt::format("expected the frame number {}, got {}: frames are missing", taken_ + 1, header->sequence));
      co_return false;
    }
    const bool is_there = co_await arrives(frame);
    if (!is_there) co_return !stopped_ && !is_mute_;
    ++taken_;
  }
  const bool admitted = admit(*header);
  if (!admitted || header->type == FrameType::kCredit) co_return admitted;
  if (requested_bytes(frame.header, frame.payload) > agreed_.max_payload_bytes) {
    fail(ErrorCode::kTooLarge, header->id,
         fmt::format("expected a read of at most {} bytes, got {}", agreed_.max_payload_bytes,
                     requested_bytes(frame.header, frame.payload)));
    co_return false;
  }
  inbox_.push_back(std::move(frame));
  wake_.cancel();
  co_return true;
}

// Judges a whole frame by its header.
bool Session::admit(const FrameHeader& header) {
  const Manner manner = manner_of(header.type);
  const int type = static_cast<int>(header.type);
  if (manner == Manner::kNotFromHost || header.error != ErrorCode::kNone) {
    fail(ErrorCode::kProtocol, header.id,
         fmt::format("expected a request, got a frame of type {} with error {}", type,
                     static_cast<std::uint32_t>(header.error)));
    return false;
  }
  const unsigned flags = manner == Manner::kPosted ? unsigned{wire::kPosted} : 0u;
  // kCredit has no flags to tell apart: it is always posted.
  if (header.flags != flags && header.type != FrameType::kCredit) {
    fail(ErrorCode::kProtocol, header.id,
         fmt::format("expected flags {} on a frame of type {}, got {}", flags, type, header.flags));
    return false;
  }
  if (header.type == FrameType::kCredit && header.size != 0) {
    fail(ErrorCode::kTooLarge, header.id, fmt::format("expected no payload with credit, got {} bytes", header.size));
    return false;
  }
  if (!take_credit(header)) return false;
  if (header.type == FrameType::kCredit || receive_credits_->accept(header.size)) return true;
  fail(ErrorCode::kProtocol, header.id,
       fmt::format("expected at most {} frames and {} bytes in flight, got a frame of {} bytes beyond that",
                   options_.version.window_slots, options_.version.window_bytes, header.size));
  return false;
}

bool Session::take_credit(const FrameHeader& header) {
  if (header.credit_slots > owed_slots_ || header.credit_bytes > owed_bytes_) {
    fail(ErrorCode::kProtocol, header.id,
         fmt::format("expected credit for at most {} frames and {} bytes, got {} and {}", owed_slots_, owed_bytes_,
                     header.credit_slots, header.credit_bytes));
    return false;
  }
  if (header.credit_slots == 0 && header.credit_bytes == 0) return true;
  owed_slots_ -= header.credit_slots;
  owed_bytes_ -= header.credit_bytes;
  send_credits_->give_back(header.credit_slots, header.credit_bytes);
  wake_.cancel();
  return true;
}

// ---- worker

awaitable<void> Session::work() {
  while (!stopped_) {
    if (inbox_.empty()) {
      co_await wait(kUntilWoken);
      continue;
    }
    const Frame frame = std::move(inbox_.front());
    inbox_.pop_front();
    if (!book_command(frame.header)) break;
    Outcome outcome = co_await transact(frame);
    receive_credits_->consume(frame.header.size);
    ++unreturned_slots_;
    unreturned_bytes_ += frame.header.size;
    if (stopped_) break;
    co_await send_outcome(frame.header, std::move(outcome));
    const bool is_tight = unreturned_bytes_ + agreed_.max_payload_bytes > options_.version.window_bytes;
    if (!stopped_ && (receive_credits_->due() || is_tight)) co_await return_credit();
  }
}

// False if the client piles up results that it never fetches.
bool Session::book_command(const FrameHeader& header) {
  if (header.type != FrameType::kCommand) return true;
  const std::uint64_t bytes = kCommandOverhead + header.size;  // rays come back in as many bytes as they were sent
  unclaimed_[header.id] += bytes;
  unclaimed_bytes_ += bytes;
  if (unclaimed_bytes_ <= options_.max_unclaimed_bytes) return true;
  fail(ErrorCode::kTooLarge, header.id,
       fmt::format("expected at most {} bytes of commands before their completions are waited or polled for, got {}",
                   options_.max_unclaimed_bytes, unclaimed_bytes_));
  return false;
}

void Session::settle_command(std::uint32_t ticket) {
  const auto found = unclaimed_.find(ticket);
  if (found == unclaimed_.end()) return;
  unclaimed_bytes_ -= found->second;
  unclaimed_.erase(found);
}

awaitable<Outcome> Session::transact(const Frame& frame) {
  Outcome outcome;
  work_.all = 0;
  work_.done = 0;
  work_.ticket = frame.header.id;
  std::function<void()> job = [this, &frame, &outcome] {
    if (frame.memory_error) slot_.board().add_memory_error(*frame.memory_error);
    outcome = slot_.board().transact(frame.header, frame.payload, work_);
  };
  const bool shows_progress = (agreed_.capabilities & wire::kProgressFrames) != 0;
  const std::exception_ptr fault = co_await run_on_compute(std::move(job), shows_progress);
  if (fault) std::rethrow_exception(fault);
  co_return outcome;
}

awaitable<void> Session::send_outcome(const FrameHeader& request, Outcome outcome) {
  for (Completion& completion : outcome.completions) {
    FrameHeader header{FrameType::kCompletion, wire::kPosted, completion.ticket};
    header.error = completion.error;
    settle_command(completion.ticket);
    header.time_ps = completion.time_ps;
    co_await send(header, std::move(completion.payload));
  }
  if (!outcome.reply) co_return;
  FrameHeader header{request.type, wire::kResponse, request.id};
  header.error = outcome.reply->error;
  header.time_ps = outcome.reply->time_ps;
  co_await send(header, std::move(outcome.reply->payload));
}

awaitable<void> Session::send_progress() {
  const std::uint32_t all = work_.all, done = work_.done;
  if (all == 0) co_return;
  std::vector<std::uint8_t> payload(8);
  wire::store(std::span(payload), 0, std::min(done, all));
  wire::store(std::span(payload), 4, all);
  FrameHeader header{FrameType::kProgress, wire::kPosted, work_.ticket};
  header.time_ps = slot_.board().simulated_ps();
  co_await write(header, std::move(payload));
}

// Most credit travels on other frames. It goes by itself when half the window waits, when the client could not send its
// largest frame without it, or when it may be waiting for our credit as we are for its.
awaitable<void> Session::return_credit() {
  if (unreturned_slots_ == 0) co_return;
  FrameHeader header{FrameType::kCredit, wire::kPosted, sent_};
  std::vector<std::uint8_t> nothing;
  co_await write(header, std::move(nothing));
}

// Waits until the client has room. False if the session ends instead.
awaitable<bool> Session::send(FrameHeader header, std::vector<std::uint8_t> payload) {
  if (payload.size() > agreed_.max_payload_bytes) {
    fail(ErrorCode::kInternal, header.id,
         fmt::format("the answer has {} bytes, {} are agreed", payload.size(), agreed_.max_payload_bytes));
    co_return false;
  }
  while (!stopped_ && !send_credits_->can_send(payload.size())) {
    co_await return_credit();
    if (!stopped_ && !send_credits_->can_send(payload.size())) co_await wait(kUntilWoken);
  }
  if (stopped_) co_return false;
  send_credits_->take(payload.size());
  ++owed_slots_;
  owed_bytes_ += payload.size();
  header.sequence = ++sent_;
  const bool written = co_await write_message(header, std::move(payload));
  co_return written;
}

// Puts one frame on the socket, with all the credit that the client has earned. One writer at a time: the handshake,
// then the worker, then the goodbye.
awaitable<bool> Session::write(FrameHeader header, std::vector<std::uint8_t> payload) {
  if (is_mute_) co_return true;
  header.size = static_cast<std::uint32_t>(payload.size());
  if (receive_credits_) {
    const auto returned = receive_credits_->give_back();
    header.credit_slots = returned.slots;
    header.credit_bytes = returned.bytes;
    unreturned_slots_ = 0;
    unreturned_bytes_ = 0;
  }
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  wire::encode_sealed(header, payload, bytes);
  if (bit_to_flip_) flip_bit(*std::exchange(bit_to_flip_, std::nullopt), bytes, payload);
  const std::array<asio::const_buffer, 2> buffers{asio::buffer(bytes), asio::buffer(payload)};
  error_code error;
  writing_ = true;
  co_await asio::async_write(socket_, buffers, asio::redirect_error(asio::use_awaitable, error));
  writing_ = false;
  if (error) stop();
  co_return !error;
}

}  // namespace gicube::emu

// Data transfer of a session: incoming frames, execution on the board, outgoing frames.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <csignal>

#include "gicube/wire/checksum.h"
#include "server/faults/fault_point.h"
#include "session.h"

namespace gicube::emu {

using wire::ErrorCode;
using wire::FrameHeader;
using wire::FrameType;
using Arrival = wire::ReliableWindow::Arrival;

namespace {

constexpr std::uint64_t kBytesOfFrame = 256;  // chosen: more than the queues need per frame in addition to the payload

enum class Manner { kNotFromHost, kPosted, kNonPosted };

Manner manner_of(FrameType type) {
  using enum FrameType;
  constexpr std::array kPosted{kCredit, kRegisterWrite, kMemoryWrite, kCommand};
  constexpr std::array kNotFromHost{kVersion, kCompletion, kProgress};
  if (std::ranges::find(kPosted, type) != kPosted.end()) return Manner::kPosted;
  const bool from_host = std::ranges::find(kNotFromHost, type) == kNotFromHost.end();
  return from_host ? Manner::kNonPosted : Manner::kNotFromHost;
}

// The length that a kMemoryRead requests; 0 if its payload is malformed, which the board reports.
std::uint64_t requested_bytes(const FrameHeader& header, std::span<const std::uint8_t> payload) {
  if (header.type != FrameType::kMemoryRead || payload.size() != 16) return 0;
  return wire::load<std::uint64_t>(payload, 8);
}

}  // namespace

// ---- reader

awaitable<void> Session::read_frames(std::shared_ptr<Session> self, Connected connection) {
  try {
    bool more = true;
    while (more && !self->stopped_) {
      Connection::Incoming incoming = co_await connection->read(self->agreed_.max_payload_bytes);
      if (self->connection_ != connection) co_return;  // another connection has replaced it, or the session has ended
      if (!incoming.frame) {
        self->lose(connection, incoming.fault);
        co_return;
      }
      more = co_await self->take(connection, std::move(*incoming.frame));
    }
  } catch (const LastWord& fault) {
    self->fail(fault);
  } catch (const std::exception& error) {  // no memory for a payload
    self->fail(error);
  }
}

// Returns false if nothing more may be read from this connection. Throws LastWord to end the session.
awaitable<bool> Session::take(const Connected& connection, Connection::Frame frame) {
  const FrameHeader header = frame.header;
  if (!wire::is_free(header.type)) {
    const bool more = co_await take_numbered(connection, std::move(frame));
    co_return more;
  }
  if (header.type == FrameType::kVersion && header.flags == wire::kPosted && header.error == ErrorCode::kNone) {
    stop();  // the client closes the session
    co_return false;
  }
  admit(header);
  if (window_.arrival(header) == Arrival::kGap) {
    lose(connection, LastWord{ErrorCode::kCorrupted, header.id,
                              fmt::format("expected frame number {}, which was sent, got none", window_.taken() + 1)});
    co_return false;
  }
  // A client that waits too long asks what was sent. No answer is needed while a frame is being sent.
  if (header.flags != wire::kPosted && connection->idle() && !delivering_) {
    connection_->send(window_.credit_frame(wire::kResponse), wire::no_payload());
  }
  co_return true;
}

awaitable<bool> Session::take_numbered(const Connected& connection, Connection::Frame frame) {
  const FrameHeader header = frame.header;
  const Arrival arrival = window_.arrival(header);
  if (arrival == Arrival::kAgain) co_return true;
  if (arrival == Arrival::kGap) {
    lose(connection, LastWord{ErrorCode::kCorrupted, header.id,
                              fmt::format("expected frame number {}, got {}: frames are missing", window_.taken() + 1,
                                          header.sequence)});
    co_return false;
  }
  FaultAction action;
  const bool is_planned = header.type != FrameType::kCheckpoint;  // otherwise saving a checkpoint would change a run
  if (is_planned && wire::sequence_step(judged_, header.sequence) > 0) {
    judged_ = header.sequence;
    action = slot_.faults().taken(wire::kFrameHeaderBytes + header.size);
  }
  if (action.any()) {
    std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
    wire::encode(header, bytes);
    if (action.kill) ::raise(SIGKILL);
    co_await pause(action.pause);
    if (connection_ != connection) co_return false;
    if (action.hang) connection->hang();
    if (action.hang || action.drop) co_return true;
    if (action.flipped_bit) {
      flip_bit(*action.flipped_bit, bytes, frame.payload);
      const std::uint32_t expected = wire::frame_checksum(bytes, frame.payload);
      const auto got = wire::load<std::uint32_t>(bytes, wire::kFrameHeaderBytes - sizeof(std::uint32_t));
      lose(connection, LastWord{ErrorCode::kCorrupted, header.id,
                                fmt::format("expected the checksum 0x{:08x}, got 0x{:08x}", expected, got)});
    } else if (action.cut) {
      lose(connection, std::nullopt);
    }
    if (connection_ != connection) co_return false;
  }
  window_.take();
  admit(header);
  if (const std::uint64_t bytes = requested_bytes(header, frame.payload); bytes > agreed_.max_payload_bytes) {
    throw LastWord{ErrorCode::kTooLarge, header.id,
                   fmt::format("expected a read of at most {} bytes, got {}", agreed_.max_payload_bytes, bytes)};
  }
  inbox_.push_back(Frame{{header, std::move(frame.payload)}, action.memory_error});
  wake_.cancel();
  co_return true;
}

// Checks a complete frame by its header.
void Session::admit(const FrameHeader& header) {
  const Manner manner = manner_of(header.type);
  const bool is_credit = header.type == FrameType::kCredit;
  const int type = static_cast<int>(header.type);
  const auto refuse = [&header](ErrorCode error, std::string text) {
    throw LastWord{error, header.id, std::move(text)};
  };
  if (manner == Manner::kNotFromHost || header.error != ErrorCode::kNone) {
    refuse(ErrorCode::kProtocol, fmt::format("expected a request, got a frame of type {} with error {}", type,
                                             static_cast<std::uint32_t>(header.error)));
  }
  const unsigned flags = manner == Manner::kPosted ? unsigned{wire::kPosted} : 0u;
  // The flags of credit frames carry no information; they are always posted.
  if (header.flags != flags && !is_credit) {
    refuse(ErrorCode::kProtocol,
           fmt::format("expected flags {} on a frame of type {}, got {}", flags, type, header.flags));
  }
  if (is_credit && header.size != 0) {
    refuse(ErrorCode::kTooLarge, fmt::format("expected no payload with credit, got {} bytes", header.size));
  }
  if (!window_.take_credit(header)) {
    const std::uint64_t bytes =
        header.credit_slots <= window_.kept_frames() ? window_.bytes_of(header.credit_slots) : window_.kept_bytes();
    refuse(ErrorCode::kProtocol, fmt::format("expected credit for at most {} frames and {} bytes, got {} and {}",
                                             window_.kept_frames(), bytes, header.credit_slots, header.credit_bytes));
  }
  slot_.set_held(held());
  if (header.credit_slots > 0) wake_.cancel();
  if (is_credit || window_.accept(header.size)) return;
  refuse(ErrorCode::kProtocol,
         fmt::format("expected at most {} frames and {} bytes in flight, got a frame of {} bytes beyond that",
                     options_.version.window_slots, options_.version.window_bytes, header.size));
}

// ---- worker

awaitable<void> Session::work() {
  while (!stopped_) {
    if (inbox_.empty()) {
      co_await sleep(wake_, kUntilWoken);
      continue;
    }
    const Frame frame = std::move(inbox_.front());
    inbox_.pop_front();
    awaitable<TransactionResult> done =
        frame.header.type == FrameType::kCheckpoint ? checkpoint(frame) : transact(frame);
    TransactionResult result = co_await std::move(done);
    window_.consume(frame.header.size);
    if (stopped_) break;
    if (result.ticket_in_use) {
      throw LastWord{ErrorCode::kProtocol, frame.header.id,
                     fmt::format("ticket: expected one that no command in progress has, got {}", frame.header.id)};
    }
    check_held(frame.header);
    co_await send_result(frame.header, std::move(result));
    slot_.set_held(held());
    const bool is_due = window_.credit_is_due() || window_.may_keep_out(agreed_.max_payload_bytes);
    if (!stopped_ && is_due) return_credit();
  }
}

// Bytes currently held for the client.
std::uint64_t Session::held() const {
  const std::size_t frames = window_.kept_frames() + (connection_ ? connection_->waiting_frames() : 0);
  return held_bytes_ + window_.kept_bytes() + frames * kBytesOfFrame;
}

// Throws LastWord if the client accumulates results that it never fetches, answers that it never takes, or credit that
// it never reads. The client's own window is no limit, because the client chooses its size.
void Session::check_held(const FrameHeader& header) const {
  const std::uint64_t bytes = held();
  if (bytes <= options_.max_held_bytes) return;
  note(AuditEvent::kLimitReached, fmt::format("unfetched results of {} bytes", bytes));
  throw LastWord{ErrorCode::kTooLarge, header.id,
                 fmt::format("expected at most {} bytes of results that the client has not fetched, got {}",
                             options_.max_held_bytes, bytes)};
}

awaitable<TransactionResult> Session::transact(const Frame& frame) {
  TransactionResult result;
  has_worked_ = true;
  progress_.all = progress_.done = 0;
  progress_.ticket = frame.header.id;
  std::uint64_t held_bytes = 0;  // separate, because the session reads held_bytes_ on another thread
  std::function<void()> job = [this, &frame, &result, &held_bytes] {
    if (frame.memory_error) slot_.board().add_memory_error(*frame.memory_error);
    result = slot_.board().transact(frame.header, frame.payload, progress_);
    held_bytes = slot_.board().held_bytes();
  };
  const bool shows_progress = (agreed_.capabilities & wire::kProgressFrames) != 0;
  co_await run_on_compute(std::move(job), shows_progress, options_.max_command_time);
  held_bytes_ = held_bytes;
  co_return result;
}

awaitable<void> Session::send_result(const FrameHeader& request, TransactionResult result) {
  for (Completion& completion : result.completions) {
    FrameHeader header{FrameType::kCompletion, wire::kPosted, completion.ticket};
    header.error = completion.error;
    header.time_ps = completion.time_ps;
    co_await keep_pace(completion.time_ps);
    co_await send(header, std::move(completion.payload));
  }
  if (!result.reply) co_return;
  FrameHeader header{request.type, wire::kResponse, request.id};
  header.error = result.reply->error;
  header.time_ps = result.reply->time_ps;
  co_await keep_pace(header.time_ps);
  co_await send(header, std::move(result.reply->payload));
}

// In real-time mode, delays an answer until its simulated time.
awaitable<void> Session::keep_pace(std::uint64_t time_ps) {
  if (!realtime_) co_return;
  const auto due = begin_ + std::chrono::nanoseconds(time_ps / 1000);
  while (!stopped_ && std::chrono::steady_clock::now() < due) {
    co_await sleep(wake_, due - std::chrono::steady_clock::now());
  }
}

void Session::send_progress() {
  const std::uint32_t all = progress_.all, done = progress_.done;
  if (all == 0 || !connection_ || !connection_->idle()) return;
  std::vector<std::uint8_t> payload(8);
  wire::store(std::span(payload), 0, std::min(done, all));
  wire::store(std::span(payload), 4, all);
  FrameHeader header{FrameType::kProgress, wire::kPosted, progress_.ticket};
  header.time_ps = slot_.board().simulated_ps();
  put(header, wire::share(std::move(payload)));
}

// Credit is usually returned in other frames. It is sent separately if half the window is waiting, if the client could
// not send its largest frame without it, or if both sides might be waiting for each other's credit.
void Session::return_credit() {
  if (connection_ && window_.owes_credit()) connection_->send(window_.credit_frame(wire::kPosted), wire::no_payload());
}

// Waits until the client has room, or until the session ends.
awaitable<void> Session::send(FrameHeader header, std::vector<std::uint8_t> payload) {
  if (payload.size() > agreed_.max_payload_bytes) {
    throw LastWord{
        ErrorCode::kInternal, header.id,
        fmt::format("expected an answer of at most {1} bytes, got {0}", payload.size(), agreed_.max_payload_bytes)};
  }
  while (!stopped_ && !window_.can_send(payload.size())) {
    return_credit();
    co_await sleep(wake_, kUntilWoken);
  }
  if (stopped_) co_return;
  const wire::ReliableWindow::Sent frame = window_.keep(header, wire::share(std::move(payload)));
  co_await deliver(frame);
}

// Sends a frame for the first time. If the connection has ended, the next one will send it.
awaitable<void> Session::deliver(const wire::ReliableWindow::Sent& frame) {
  const bool is_planned = frame.header.type != FrameType::kCheckpoint;
  const FaultAction action =
      is_planned ? slot_.faults().sent(wire::kFrameHeaderBytes + frame.payload->size()) : FaultAction();
  const Connected connection = connection_;
  if (action.any()) {
    delivering_ = true;
    // Earlier frames must not be lost with the process, because the log would then not match the plan and the traffic.
    while (!stopped_ && action.kill && connection && !connection->idle()) co_await pause(std::chrono::milliseconds(1));
    if (action.kill) ::raise(SIGKILL);
    co_await pause(action.pause);
    delivering_ = false;
    if (!connection || connection_ != connection) co_return;
    if (action.cut) lose(connection, std::nullopt);
    if (action.hang) connection->hang();
    if (action.drop) co_return;
  }
  put(frame.header, frame.payload, action.flipped_bit);
  if (action.twice) put(frame.header, frame.payload);
}

// Queues one frame, with all credit that is to be returned.
void Session::put(FrameHeader header, wire::Payload payload, std::optional<std::uint32_t> flipped_bit) {
  if (!connection_) return;
  window_.put_credit(header);
  connection_->send(header, std::move(payload), flipped_bit);
}

}  // namespace gicube::emu

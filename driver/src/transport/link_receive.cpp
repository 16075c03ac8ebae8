// The receiving half of Link, which runs on the stream's thread, and the board's error replies as the driver's typed
// errors.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "link.h"

namespace gicube {

std::string error_text(std::span<const std::uint8_t> payload) {
  constexpr std::size_t kLongestText = 4000;  // chosen: fits all faults of a configuration
  std::string text;
  for (const std::uint8_t byte : payload.first(std::min(payload.size(), kLongestText))) {
    const bool control = (byte < 0x20 && byte != '\n') || byte == 0x7F;
    text += control ? '?' : static_cast<char>(byte);
  }
  return text.empty() ? "no reason given" : text;
}

bool ends_session(wire::ErrorCode code) {
  using enum wire::ErrorCode;
  constexpr std::array kEndings{kProtocol, kVersion, kTooLarge, kBusy, kCancelled, kTaken};
  return std::ranges::find(kEndings, code) != kEndings.end();
}

Loss cause_of(wire::ErrorCode last_word) {
  switch (last_word) {
    case wire::ErrorCode::kTaken: return Loss::kTakenOver;
    case wire::ErrorCode::kTooLarge:  // we keep to the limits: so the size was damaged
    case wire::ErrorCode::kCorrupted: return Loss::kCorrupted;
    default: return Loss::kEnded;
  }
}

void throw_error(wire::ErrorCode code, const std::string& text) {
  switch (code) {
    case wire::ErrorCode::kBusy: throw BoardBusy("the board is busy: " + text);
    case wire::ErrorCode::kVersion: throw VersionMismatch("the board has another protocol version: " + text);
    case wire::ErrorCode::kUnsupported: throw Unsupported(text);
    case wire::ErrorCode::kMemory: throw MemoryFault(text);
    case wire::ErrorCode::kProtocol:
    case wire::ErrorCode::kTooLarge: throw DeviceLost("the board ended the session: " + text, Loss::kEnded);
    case wire::ErrorCode::kCancelled: throw DeviceLost("the board shuts down: " + text, Loss::kEnded);
    case wire::ErrorCode::kCorrupted: throw DeviceLost(text, Loss::kCorrupted);
    case wire::ErrorCode::kTaken: throw DeviceLost(text, Loss::kTakenOver);
    default: throw Rejected(text);
  }
}

// Checks only what must hold before memory is allocated: the header may be damaged, the checksum comes with the
// payload.
StreamFault Link::check_header(const wire::FrameHeader& header) {
  const std::lock_guard lock(mutex_);
  if (deaf_) return {"closed", Loss::kClosed};
  if (phase_ == Phase::kOpen && header.size > agreed_.max_payload_bytes) {
    return {fmt::format("the board announced {} payload bytes, agreed were at most {}", header.size,
                        agreed_.max_payload_bytes),
            Loss::kCorrupted};
  }
  if (phase_ == Phase::kHandshake && header.size > wire::kMaxHandshakePayload) {
    return {fmt::format("the peer announced a handshake of {} bytes, at most {} are allowed", header.size,
                        wire::kMaxHandshakePayload)};
  }
  return {};
}

// Everything that was not requested is a fault: so nothing that arrives can grow without a limit.
StreamFault Link::check_frame(const wire::FrameHeader& header) {
  const std::string id = std::to_string(header.id);
  if (header.type == wire::FrameType::kVersion) {
    const bool is_last_word = header.error != wire::ErrorCode::kNone && header.size <= wire::kMaxHandshakePayload;
    if (!is_last_word) return {"the board sent a second version frame"};
  } else if (header.type == wire::FrameType::kCredit) {
    if (header.size != 0) return {"the board sent a credit frame with a payload"};
  } else if (header.type == wire::FrameType::kCompletion) {
    const auto command = commands_.find(header.id);
    if (command == commands_.end() || command->second.result) return {"the board completed an unknown command " + id};
  } else if (header.type == wire::FrameType::kProgress) {
    if (header.size != 8) return {"the board sent a progress frame of " + std::to_string(header.size) + " bytes"};
  } else {
    const auto pending = pending_.find(header.id);
    const bool expected = (header.flags & wire::kResponse) != 0 && pending != pending_.end() &&
                          pending->second.type == header.type && !pending->second.response;
    if (!expected) return {"the board answered a request that was not made, id " + id};
  }
  const bool fits = wire::is_free(header.type) || window_.accept(header.size);
  return fits ? StreamFault{} : StreamFault{"the board sent more than it had credit for"};
}

StreamFault Link::take_frame(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) {
  const std::lock_guard lock(mutex_);
  if (deaf_) return {"closed", Loss::kClosed};
  last_frame_ = std::chrono::steady_clock::now();
  if (header.type != wire::FrameType::kCredit) last_heard_ = last_frame_;  // credit also flows while the work hangs
  changed_.notify_all();  // the waiters run when this frame has been handled
  if (phase_ == Phase::kHandshake) return take_version(header, payload);
  const auto arrival = window_.arrival(header);
  if (arrival == wire::ReliableWindow::Arrival::kGap) {
    const std::string missing = fmt::format("frames of the board are missing: expected number {}", window_.taken() + 1);
    // A credit frame has no number of its own; it has the last one that the board used.
    return {header.type == wire::FrameType::kCredit
                ? fmt::format("{}, the board says that it has sent up to number {}", missing, header.id)
                : fmt::format("{}, got {}", missing, header.sequence),
            Loss::kCorrupted};
  }
  if (arrival == wire::ReliableWindow::Arrival::kAgain) return {};
  const bool is_numbered = !wire::is_free(header.type);
  if (is_numbered) window_.take();
  if (is_numbered || header.credit_slots > 0) attempts_ = 0;
  if (StreamFault fault = check_frame(header); !fault.text.empty()) return fault;
  if (!window_.take_credit(header)) return {"the board handed back credit that it never took"};
  const std::size_t bytes = payload.size();
  switch (header.type) {
    case wire::FrameType::kCredit: return {};
    case wire::FrameType::kVersion:
      return {"the board ended the session: " + error_text(payload), cause_of(header.error)};
    case wire::FrameType::kCompletion: take_completion(header, std::move(payload)); break;
    case wire::FrameType::kProgress: take_progress(header, payload); return {};
    default: take_response(header, std::move(payload)); break;
  }
  window_.consume(bytes);
  if (window_.credit_is_due()) send_credit(wire::kPosted);
  return {};
}

void Link::take_response(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) {
  const auto pending = pending_.find(header.id);
  if (pending->second.abandoned) {
    pending_.erase(pending);
  } else {
    pending->second.response = Response{header.error, header.time_ps, std::move(payload)};
  }
}

void Link::take_completion(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) {
  const auto command = commands_.find(header.id);
  if (command == commands_.end()) return;
  if (command->second.forgotten) {
    commands_.erase(command);
  } else {
    command->second.result = CommandResult{header.error, header.time_ps, std::move(payload)};
  }
}

void Link::take_progress(const wire::FrameHeader& header, std::span<const std::uint8_t> payload) {
  for (auto& [id, pending] : pending_) {
    if (pending.watched_ticket != header.id || pending.response) continue;
    pending.progress = {wire::load<std::uint32_t>(payload, 0), wire::load<std::uint32_t>(payload, 4)};
  }
}

void Link::stream_ended(const StreamFault& reason) {
  const std::lock_guard lock(mutex_);
  if (deaf_) return;
  deaf_ = true;
  phase_ = Phase::kBroken;
  broken_ = reason;
  changed_.notify_all();
}

}  // namespace gicube

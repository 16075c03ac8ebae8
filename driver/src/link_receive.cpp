// The receiving half of Link: it runs on the stream's thread.
#include <utility>

#include "link.h"
#include "link_error.h"

namespace gicube {

// Only what has to be known before memory is taken: the header may be damaged, the checksum comes with the payload.
std::string Link::check_header(const wire::FrameHeader& header) {
  const std::lock_guard lock(mutex_);
  if (phase_ == Phase::kBroken) return broken_reason_;
  if (phase_ == Phase::kOpen && header.size > agreed_.max_payload_bytes) {
    return "the board announced " + std::to_string(header.size) + " payload bytes, agreed were at most " +
           std::to_string(agreed_.max_payload_bytes);
  }
  if (phase_ == Phase::kHandshake && header.size > wire::kMaxHandshakePayload) {
    return "the peer announced a handshake of " + std::to_string(header.size) + " bytes, at most " +
           std::to_string(wire::kMaxHandshakePayload) + " are allowed";
  }
  return {};
}

// Whatever the board did not owe us is a fault: so nothing that comes in can grow without a limit.
std::string Link::check_frame(const wire::FrameHeader& header) {
  const std::string id = std::to_string(header.id);
  if (header.type == wire::FrameType::kVersion) {
    const bool is_last_word = header.error != wire::ErrorCode::kNone && header.size <= wire::kMaxHandshakePayload;
    if (!is_last_word) return "the board sent a second version frame";
  } else if (header.type == wire::FrameType::kCredit) {
    if (header.size != 0) return "the board sent a credit frame with a payload";
  } else if (header.type == wire::FrameType::kCompletion) {
    const auto command = commands_.find(header.id);
    if (command == commands_.end() || command->second.result) return "the board completed an unknown command " + id;
  } else if (header.type == wire::FrameType::kProgress) {
    if (header.size != 8) return "the board sent a progress frame of " + std::to_string(header.size) + " bytes";
  } else {
    const auto pending = pending_.find(header.id);
    const bool expected = (header.flags & wire::kResponse) != 0 && pending != pending_.end() &&
                          pending->second.type == header.type && !pending->second.response;
    if (!expected) return "the board answered a request that was not made, id " + id;
  }
  if (!wire::is_free(header.type) && !receive_credits_.accept(header.size)) {
    return "the board sent more than it had credit for";
  }
  return {};
}

std::string Link::take_frame(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) {
  const std::lock_guard lock(mutex_);
  if (phase_ == Phase::kBroken) return broken_reason_;
  last_heard_ = std::chrono::steady_clock::now();
  changed_.notify_all();  // the waiters run once this frame is dealt with
  if (phase_ == Phase::kHandshake) return take_version(header, payload);
  if (!wire::is_free(header.type)) {
    const std::int32_t step = wire::sequence_step(taken_, header.sequence);
    if (step <= 0) return {};  // it came twice
    if (step > 1) {
      return "frames of the board are missing: expected number " + std::to_string(taken_ + 1) + ", got " +
             std::to_string(header.sequence);
    }
    ++taken_;
  }
  if (std::string fault = check_frame(header); !fault.empty()) return fault;
  if (std::string fault = take_credit(header); !fault.empty()) return fault;
  const std::size_t bytes = payload.size();
  switch (header.type) {
    case wire::FrameType::kCredit: return {};
    case wire::FrameType::kVersion: return "the board ended the session: " + error_text(payload);
    case wire::FrameType::kCompletion: take_completion(header, std::move(payload)); break;
    case wire::FrameType::kProgress: take_progress(header, payload); return {};
    default: take_response(header, std::move(payload)); break;
  }
  receive_credits_.consume(bytes);
  if (receive_credits_.due()) {
    wire::FrameHeader credit;
    credit.type = wire::FrameType::kCredit;
    credit.flags = wire::kPosted;
    const auto returned = receive_credits_.give_back();
    credit.credit_slots = returned.slots;
    credit.credit_bytes = returned.bytes;
    credit.id = sent_;
    stream_.send(credit, {});
  }
  return {};
}

std::string Link::take_version(const wire::FrameHeader& header, std::span<const std::uint8_t> payload) {
  if (header.type != wire::FrameType::kVersion || (header.flags & wire::kResponse) == 0) {
    return "the peer answered the handshake with a frame of another type";
  }
  if (header.error != wire::ErrorCode::kNone) {
    refusal_ = header.error;
    return error_text(payload);
  }
  if (payload.size() < wire::kVersionBytes) {
    return "the peer's version is cut short, " + std::to_string(payload.size()) + " bytes";
  }
  const auto theirs = wire::decode_version(payload.first<wire::kVersionBytes>());
  const auto agreed = wire::agree(options_.mine, theirs);
  if (theirs.major != options_.mine.major) {
    refusal_ = wire::ErrorCode::kVersion;
    return "major version " + std::to_string(theirs.major) + ", this driver's is " +
           std::to_string(options_.mine.major);
  }
  if (!agreed) return "the board's limits leave no room for a frame";
  // Credit that we hold back, less than half the window, must never keep the board from its largest frame.
  if (options_.mine.window_bytes / 2 < agreed->max_payload_bytes) return "the driver's window is too small";
  agreed_ = *agreed;
  send_credits_ = wire::SendCredits(theirs.window_slots, theirs.window_bytes);
  phase_ = Phase::kOpen;
  return {};
}

std::string Link::take_credit(const wire::FrameHeader& header) {
  if (header.credit_slots > unreturned_slots_ || header.credit_bytes > unreturned_bytes_) {
    return "the board handed back credit that it never took";
  }
  unreturned_slots_ -= header.credit_slots;
  unreturned_bytes_ -= header.credit_bytes;
  send_credits_.give_back(header.credit_slots, header.credit_bytes);
  return {};
}

void Link::take_response(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) {
  const auto pending = pending_.find(header.id);
  if (pending->second.abandoned) {
    pending_.erase(pending);
    return;
  }
  pending->second.error = header.error;
  pending->second.response = Response{header.error, header.time_ps, std::move(payload)};
}

void Link::take_completion(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) {
  const auto command = commands_.find(header.id);
  if (command == commands_.end()) return;
  if (command->second.forgotten) {
    commands_.erase(command);
    return;
  }
  command->second.result = CommandResult{header.error, header.time_ps, std::move(payload)};
}

void Link::take_progress(const wire::FrameHeader& header, std::span<const std::uint8_t> payload) {
  for (auto& [id, pending] : pending_) {
    if (pending.watched_ticket != header.id || pending.response) continue;
    pending.progress = {wire::load<std::uint32_t>(payload, 0), wire::load<std::uint32_t>(payload, 4)};
  }
}

void Link::stream_ended(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  if (phase_ != Phase::kBroken) {
    phase_ = Phase::kBroken;
    broken_reason_ = reason;
  }
  changed_.notify_all();
}

}  // namespace gicube

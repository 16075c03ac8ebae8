// The receiving half of Link: it runs on the stream's thread.
#include <utility>

#include "link.h"
#include "link_error.h"

namespace gicube {

// Only what has to be known before memory is taken: the header may be damaged, the checksum comes with the payload.
StreamFault Link::check_header(const wire::FrameHeader& header) {
  const std::lock_guard lock(mutex_);
  if (deaf_) return {"closed", Loss::kClosed};
  if (phase_ == Phase::kOpen && header.size > agreed_.max_payload_bytes) {
    return {"the board announced " + std::to_string(header.size) + " payload bytes, agreed were at most " +
                std::to_string(agreed_.max_payload_bytes),
            Loss::kCorrupted};
  }
  if (phase_ == Phase::kHandshake && header.size > wire::kMaxHandshakePayload) {
    return {"the peer announced a handshake of " + std::to_string(header.size) + " bytes, at most " +
                std::to_string(wire::kMaxHandshakePayload) + " are allowed",
            Loss::kEnded};
  }
  return {};
}

// Whatever the board did not owe us is a fault: so nothing that comes in can grow without a limit.
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
  if (!wire::is_free(header.type) && !receive_credits_.accept(header.size)) {
    return {"the board sent more than it had credit for"};
  }
  return {};
}

StreamFault Link::take_frame(const wire::FrameHeader& header, std::vector<std::uint8_t> payload) {
  const std::lock_guard lock(mutex_);
  if (deaf_) return {"closed", Loss::kClosed};
  last_frame_ = std::chrono::steady_clock::now();
  if (header.type != wire::FrameType::kCredit) last_heard_ = last_frame_;  // credit flows while the work hangs, too
  changed_.notify_all();  // the waiters run once this frame is dealt with
  if (phase_ == Phase::kHandshake) return take_version(header, payload);
  bool is_new = true;
  if (StreamFault fault = take_number(header, is_new); !fault.text.empty() || !is_new) return fault;
  if (StreamFault fault = check_frame(header); !fault.text.empty()) return fault;
  if (StreamFault fault = take_credit(header); !fault.text.empty()) return fault;
  const std::size_t bytes = payload.size();
  switch (header.type) {
    case wire::FrameType::kCredit: return {};
    case wire::FrameType::kVersion:
      return {"the board ended the session: " + error_text(payload), cause_of(header.error)};
    case wire::FrameType::kCompletion: take_completion(header, std::move(payload)); break;
    case wire::FrameType::kProgress: take_progress(header, payload); return {};
    default: take_response(header, std::move(payload)); break;
  }
  receive_credits_.consume(bytes);
  if (receive_credits_.due()) send_credit(wire::kPosted);
  return {};
}

// A frame that was taken before is not new. A credit frame tells the last number that was used before it.
StreamFault Link::take_number(const wire::FrameHeader& header, bool& is_new) {
  const bool is_credit = header.type == wire::FrameType::kCredit;
  if (wire::is_free(header.type) && !is_credit) return {};
  const std::uint32_t number = is_credit ? header.id : header.sequence;
  const std::int32_t step = wire::sequence_step(taken_, number);
  if (step > (is_credit ? 0 : 1)) {
    return {"frames of the board are missing: expected number " + std::to_string(taken_ + 1) + ", got " +
                std::to_string(number),
            Loss::kCorrupted};
  }
  if (is_credit) return {};
  is_new = step == 1;
  if (!is_new) return {};
  ++taken_;
  attempts_ = 0;
  return {};
}

// Credit comes back in the order in which frames were sent, so it also says which of them need not be kept.
StreamFault Link::take_credit(const wire::FrameHeader& header) {
  std::uint64_t bytes = 0;
  const bool fits = header.credit_slots <= kept_.size();
  for (std::size_t i = 0; fits && i < header.credit_slots; ++i) bytes += kept_[i].payload->size();
  if (!fits || header.credit_bytes != bytes) return {"the board handed back credit that it never took"};
  if (header.credit_slots == 0) return {};
  forget_consumed(header.credit_slots);
  send_credits_.give_back(header.credit_slots, header.credit_bytes);
  attempts_ = 0;
  return {};
}

void Link::forget_consumed(std::uint32_t slots) {
  for (; slots > 0; --slots) {
    kept_bytes_ -= kept_.front().payload->size();
    kept_.pop_front();
  }
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

void Link::stream_ended(const StreamFault& reason) {
  const std::lock_guard lock(mutex_);
  if (deaf_) return;
  deaf_ = true;
  phase_ = Phase::kBroken;
  broken_ = reason;
  changed_.notify_all();
}

}  // namespace gicube

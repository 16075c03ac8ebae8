// Link's handshakes: for a new session, and for one that is resumed over another connection.
#include <fmt/format.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "link.h"

namespace gicube {
namespace {

using std::chrono::milliseconds;

// chosen: doubled before the second attempt in a row, and again before each later one, up to the longest pause.
constexpr milliseconds kFirstPause{5};
constexpr milliseconds kLongestPause{1000};

}  // namespace

// During a handshake: an exception ends the connection, and leaves the call that asked for it.
void Link::ask_whether_to_wait(Lock& lock) {
  lock.unlock();
  try {
    options_.while_waiting();
    lock.lock();
  } catch (...) {
    lock.lock();
    break_off({"the application did not wait for the handshake", Loss::kClosed});
    throw;
  }
}

// Replaces the connection. Afterwards the link is open, or broken with the reason.
void Link::shake_hands(Lock& lock, Fd socket, milliseconds limit) {
  phase_ = Phase::kHandshake;
  refusal_ = wire::ErrorCode::kNone;
  const std::string token = options_.token ? options_.token(socket.get()) : "";
  auto fresh =
      std::make_unique<FrameStream>(std::move(socket), static_cast<FrameSink&>(*this), options_.tap, options_.tls);
  if (std::unique_ptr<FrameStream> old = std::move(stream_)) {
    deaf_ = true;
    lock.unlock();
    old.reset();
    lock.lock();
  }
  deaf_ = false;
  stream_ = std::move(fresh);
  last_heard_ = last_frame_ = Clock::now();

  wire::VersionInfo mine = options_.mine;
  mine.session = session_;
  window_.announce(mine);
  if (session_ != 0) mine.flags = mine.wait_ms = 0;
  stream_->start();
  stream_->send({wire::FrameType::kVersion}, wire::version_payload(mine, token), token.size());

  const auto deadline = limit.count() == 0 ? Clock::time_point::max() : Clock::now() + limit;
  while (phase_ == Phase::kHandshake) {
    const auto next = options_.while_waiting ? std::min(deadline, Clock::now() + options_.probe) : deadline;
    if (next == Clock::time_point::max()) {
      changed_.wait(lock);
    } else if (changed_.wait_until(lock, next) == std::cv_status::timeout && phase_ == Phase::kHandshake) {
      if (next == deadline) {
        break_off({fmt::format("no answer from the board within {} ms", limit.count()), Loss::kTimedOut});
      } else {
        ask_whether_to_wait(lock);
      }
    }
  }
  if (refusal_ == wire::ErrorCode::kNoSession) session_ = 0;
  changed_.notify_all();
}

StreamFault Link::take_version(const wire::FrameHeader& header, std::span<const std::uint8_t> payload) {
  if (header.type != wire::FrameType::kVersion || (header.flags & wire::kResponse) == 0) {
    return {"the peer answered the handshake with a frame of another type"};
  }
  if (header.error != wire::ErrorCode::kNone) {
    refusal_ = header.error;
    return {error_text(payload), cause_of(header.error)};
  }
  if (payload.size() < wire::kVersionBytes) {
    return {fmt::format("the peer's version is truncated: {} bytes", payload.size())};
  }
  const auto theirs = wire::decode<wire::VersionInfo>(payload);
  const auto agreed = wire::agree(options_.mine, theirs);
  if (theirs.major != options_.mine.major) {
    refusal_ = wire::ErrorCode::kVersion;
    return {fmt::format("major version {}, this driver's is {}", theirs.major, options_.mine.major)};
  }
  if (!agreed) return {"the board's limits are too small for a frame"};
  // We hold back credit of less than half the window. It must never keep the board from sending its largest frame.
  if (options_.mine.window_bytes / 2 < agreed->max_payload_bytes) return {"the driver's window is too small"};
  if (session_ != 0) return take_up_session(theirs);
  agreed_ = *agreed;
  session_ = theirs.session;
  known_taken_ = 0;
  window_.open(theirs);
  phase_ = Phase::kOpen;
  return {};
}

// Sends again what the board has not taken.
StreamFault Link::take_up_session(const wire::VersionInfo& theirs) {
  if (theirs.session != session_ || !window_.fits(theirs)) {
    session_ = 0;
    return {"the board's frame numbers do not fit the session"};
  }
  if (wire::sequence_step(known_taken_, theirs.taken) > 0) attempts_ = 0;
  known_taken_ = theirs.taken;
  window_.resume(theirs, [this](const wire::FrameHeader& header, const wire::Payload& payload) {
    stream_->send(header, payload);
  });
  phase_ = Phase::kOpen;
  return {};
}

// Resumes the session, in as many attempts as are allowed. Other callers wait meanwhile.
void Link::recover(Lock& lock) {
  const std::string reason = broken_.text;
  const bool was_broken = phase_ == Phase::kBroken;
  while (phase_ == Phase::kBroken && can_recover()) {
    const int before = attempts_++;
    const auto pause =
        before == 0 ? milliseconds(0) : std::min(kLongestPause, kFirstPause * (1 << std::min(before, 10)));
    phase_ = Phase::kHandshake;
    Fd socket;
    StreamFault fault;
    lock.unlock();
    std::this_thread::sleep_for(pause);
    try {
      socket = options_.reconnect();
    } catch (const Error& error) {
      fault = {error.what(), Loss::kClosed};
    }
    lock.lock();
    if (closed_) return;
    if (fault.text.empty()) {
      shake_hands(lock, std::move(socket), options_.watchdog);
    } else {
      phase_ = Phase::kBroken;
      broken_ = fault;
      changed_.notify_all();
    }
  }
  if (!was_broken || phase_ != Phase::kOpen || !options_.log) return;
  lock.unlock();
  options_.log(fmt::format("the connection to the board was lost ({}); the session continues", reason));
  lock.lock();
}

}  // namespace gicube

#include "link.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace gicube {

wire::VersionInfo driver_version() {
  wire::VersionInfo info;
  info.capabilities =
      wire::kFunctionalLevel | wire::kApproximateLevel | wire::kCycleLevel | wire::kProgressFrames | wire::kHostRays;
  return info;
}

Link::Link(Fd socket, const LinkOptions& options) : options_(options), agreed_(options.mine), window_(options.mine) {
  const std::chrono::milliseconds waiting(options_.mine.wait_ms);
  Lock lock(mutex_);
  shake_hands(lock, std::move(socket),
              options_.watchdog.count() == 0 ? options_.watchdog : options_.watchdog + waiting);
  if (phase_ != Phase::kOpen) refuse_to_open();
}

Link::~Link() { close(); }

void Link::close() {
  const std::lock_guard lock(mutex_);
  if (phase_ == Phase::kOpen) stream_->send({wire::FrameType::kVersion, wire::kPosted}, wire::no_payload());
  closed_ = true;
  session_ = 0;
  break_off({"the application has closed it", Loss::kClosed});
}

void Link::refuse_to_open() {
  if (broken_.cause == Loss::kTimedOut) throw TimedOut(broken_.text);
  if (refusal_ == wire::ErrorCode::kBusy || refusal_ == wire::ErrorCode::kVersion) throw_error(refusal_, broken_.text);
  if (refusal_ == wire::ErrorCode::kForbidden) throw OpenFailed("the board refuses access: " + broken_.text);
  throw OpenFailed("no GI-Cube board answered: " + broken_.text);
}

bool Link::resume() {
  Lock lock(mutex_);
  changed_.wait(lock, [this] { return phase_ != Phase::kHandshake; });
  if (phase_ == Phase::kOpen) return true;
  if (session_ == 0 || !options_.reconnect) return false;
  lock.unlock();  // only this call can change that the link is broken
  Fd socket = options_.reconnect();
  lock.lock();
  shake_hands(lock, std::move(socket), options_.watchdog);
  if (phase_ == Phase::kOpen) return true;
  if (refusal_ == wire::ErrorCode::kNoSession) return false;
  if (broken_.cause == Loss::kTimedOut) throw TimedOut(broken_.text);
  throw_broken();
}

void Link::give_up(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  session_ = 0;
  break_off({reason, Loss::kEnded});
  throw_broken();
}

void Link::post(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload) {
  Lock lock(mutex_);
  const wire::FrameHeader header = next_header(lock, type, wire::kPosted, now_ps, payload.size());
  send_with_credit(header, wire::share(std::move(payload)));
}

std::uint32_t Link::command(std::uint64_t now_ps, wire::Payload payload) {
  Lock lock(mutex_);
  const wire::FrameHeader header = next_header(lock, wire::FrameType::kCommand, wire::kPosted, now_ps, payload->size());
  commands_.emplace(header.id, Command{});
  send_with_credit(header, std::move(payload));
  return header.id;
}

Response Link::wait(std::uint32_t ticket, std::uint64_t now_ps, Picoseconds deadline, const OnProgress& on_progress) {
  const bool bounded = deadline != kNoDeadline;
  std::vector<std::uint8_t> payload(bounded ? 12 : 4);
  wire::store(std::span(payload), 0, ticket);
  if (bounded) wire::store(std::span(payload), 4, deadline);
  return finish(begin(wire::FrameType::kWait, now_ps, std::move(payload), ticket), on_progress);
}

std::optional<CommandResult> Link::take(std::uint32_t ticket) {
  const std::lock_guard lock(mutex_);
  const auto command = commands_.find(ticket);
  if (command == commands_.end() || !command->second.result) return std::nullopt;
  std::optional<CommandResult> result = std::move(command->second.result);
  commands_.erase(command);
  return result;
}

void Link::forget(std::uint32_t ticket) {
  const std::lock_guard lock(mutex_);
  const auto command = commands_.find(ticket);
  if (command == commands_.end()) return;
  if (command->second.result) {
    commands_.erase(command);
  } else {
    command->second.forgotten = true;
  }
}

std::uint32_t Link::begin(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload,
                          std::uint32_t watched_ticket) {
  Lock lock(mutex_);
  const wire::FrameHeader header = next_header(lock, type, 0, now_ps, payload.size());
  Pending& pending = pending_[header.id];
  pending.type = type;
  pending.watched_ticket = watched_ticket;
  send_with_credit(header, wire::share(std::move(payload)));
  return header.id;
}

Response Link::finish(std::uint32_t id, const OnProgress& on_progress) {
  Lock lock(mutex_);
  Pending& pending = pending_.at(id);
  const std::uint32_t watched_ticket = pending.watched_ticket;
  await_response(lock, id, on_progress);
  Response response = std::move(*pending.response);
  pending_.erase(id);

  const auto command = commands_.find(watched_ticket);
  if (response.error != wire::ErrorCode::kNone && command != commands_.end() && command->second.result) {
    // An earlier wait, whose call ended when the connection was lost, has already received the result.
    response.error = wire::ErrorCode::kNone;
    response.time_ps = std::max(response.time_ps, command->second.result->time_ps);
  }
  if (response.error == wire::ErrorCode::kNone || response.error == wire::ErrorCode::kDeadline) return response;
  const std::string text = error_text(response.payload);
  if (ends_session(response.error)) break_off({text, cause_of(response.error)});
  lock.unlock();
  throw_error(response.error, text);
}

void Link::await_response(Lock& lock, std::uint32_t id, const OnProgress& on_progress) {
  Pending& pending = pending_.at(id);
  try {
    for (;;) {
      await(
          lock, [&pending] { return pending.response.has_value() || pending.progress.has_value(); }, true);
      if (pending.progress && on_progress) {
        const auto [done, all] = *std::exchange(pending.progress, std::nullopt);
        lock.unlock();
        on_progress(done, all);
        lock.lock();
        continue;
      }
      pending.progress.reset();
      if (pending.response) return;
    }
  } catch (...) {
    if (!lock.owns_lock()) lock.lock();
    if (pending.response) {
      pending_.erase(id);
    } else {  // the response will still come, and must not count as one that was not requested
      pending.abandoned = true;
      pending.watched_ticket = 0;
    }
    throw;
  }
}

// Waits for credit. Requests and tickets share the numbers; after 2^32 of them, numbers that are still in use are
// skipped.
wire::FrameHeader Link::next_header(Lock& lock, wire::FrameType type, std::uint16_t flags, std::uint64_t now_ps,
                                    std::size_t payload) {
  if (payload > agreed_.max_payload_bytes) {
    throw BadArgument("payload", fmt::format("at most {} bytes", agreed_.max_payload_bytes),
                      fmt::format("{}", payload));
  }
  await(lock, [this, payload] { return phase_ == Phase::kOpen && window_.can_send(payload); });
  do {
    ++last_id_;
  } while (last_id_ == 0 || pending_.contains(last_id_) || commands_.contains(last_id_));
  wire::FrameHeader header{type, flags, last_id_};
  header.time_ps = now_ps;
  return header;
}

// `may_leave`: exceptions of LinkOptions::while_waiting are passed to the caller.
void Link::await(Lock& lock, const auto& ready, bool may_leave) {
  auto begin = Clock::now();
  const bool asks = may_leave && options_.while_waiting;
  auto next_question = begin + options_.probe;
  while (!ready()) {
    if (phase_ == Phase::kBroken) {
      recover_or_throw(lock);
      begin = Clock::now();
      continue;
    }
    if (phase_ == Phase::kHandshake) {  // another caller does it
      changed_.wait(lock);
      begin = Clock::now();
      continue;
    }
    const auto now = Clock::now();
    const auto probe = std::max(begin, last_frame_) + options_.probe;
    const auto deadline = std::max(begin, last_heard_) + options_.watchdog;
    if (options_.watchdog.count() != 0 && now >= deadline) {
      const std::string text = fmt::format("no answer from the board within {} ms", options_.watchdog.count());
      break_off({text, Loss::kTimedOut});
      if (!can_recover()) throw TimedOut(text);
      recover_or_throw(lock);
      begin = Clock::now();
      continue;
    }
    if (now >= probe) {
      send_credit(0);
      last_frame_ = now;
      continue;
    }
    if (asks && now >= next_question) {
      lock.unlock();
      options_.while_waiting();
      lock.lock();
      next_question = Clock::now() + options_.probe;
      continue;
    }
    auto next = options_.watchdog.count() != 0 ? std::min(probe, deadline) : probe;
    if (asks) next = std::min(next, next_question);
    changed_.wait_until(lock, next);
  }
}

void Link::break_off(const StreamFault& reason) {
  if (phase_ == Phase::kBroken) return;
  phase_ = Phase::kBroken;
  deaf_ = true;
  broken_ = reason;
  if (stream_) stream_->close(reason);
  changed_.notify_all();
}

// Only with credit. Returns the credit of what has been consumed meanwhile.
void Link::send_with_credit(const wire::FrameHeader& header, wire::Payload payload) {
  wire::ReliableWindow::Sent frame = window_.keep(header, std::move(payload));
  window_.put_credit(frame.header);
  stream_->send(frame.header, std::move(frame.payload));
}

}  // namespace gicube

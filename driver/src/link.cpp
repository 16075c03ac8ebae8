#include "link.h"

#include <algorithm>
#include <utility>

#include "gicube/error.h"
#include "link_error.h"

namespace gicube {

wire::VersionInfo driver_version() {
  wire::VersionInfo info;
  info.capabilities =
      wire::kFunctionalLevel | wire::kApproximateLevel | wire::kCycleLevel | wire::kProgressFrames | wire::kHostRays;
  return info;
}

Link::Link(Fd socket, const LinkOptions& options)
    : options_(options),
      agreed_(options.mine),
      receive_credits_(options.mine.window_slots, options.mine.window_bytes),
      stream_(std::move(socket), *this) {
  stream_.start();
  shake_hands();
}

void Link::shake_hands() {
  std::vector<std::uint8_t> payload(wire::kVersionBytes);
  encode(options_.mine, std::span<std::uint8_t, wire::kVersionBytes>(payload));
  wire::FrameHeader header;
  header.type = wire::FrameType::kVersion;
  Lock lock(mutex_);
  last_heard_ = std::chrono::steady_clock::now();
  stream_.send(header, std::move(payload));
  try {
    await(lock, [this] { return phase_ == Phase::kOpen; });
  } catch (const DeviceLost&) {
    if (refusal_ == wire::ErrorCode::kBusy || refusal_ == wire::ErrorCode::kVersion) {
      throw_error(refusal_, broken_reason_);
    }
    throw OpenFailed("no GI-Cube board answered: " + broken_reason_);
  }
}

void Link::check() const {
  const std::lock_guard lock(mutex_);
  throw_if_broken();
}

void Link::give_up(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  break_off(reason);
  throw DeviceLost("the board is lost: " + broken_reason_);
}

void Link::post(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload) {
  Lock lock(mutex_);
  await_credit(lock, payload.size());
  wire::FrameHeader header;
  header.type = type;
  header.flags = wire::kPosted;
  header.id = next_id();
  header.time_ps = now_ps;
  send_with_credit(header, std::move(payload));
}

Response Link::request(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload) {
  return exchange(type, now_ps, std::move(payload), 0, {});
}

std::uint32_t Link::command(std::uint64_t now_ps, std::vector<std::uint8_t> payload) {
  Lock lock(mutex_);
  await_credit(lock, payload.size());
  wire::FrameHeader header;
  header.type = wire::FrameType::kCommand;
  header.flags = wire::kPosted;
  header.id = next_id();
  header.time_ps = now_ps;
  commands_.emplace(header.id, Command{});
  send_with_credit(header, std::move(payload));
  return header.id;
}

Response Link::wait(std::uint32_t ticket, std::uint64_t now_ps, Picoseconds deadline, const OnProgress& on_progress) {
  const bool bounded = deadline != kNoDeadline;
  std::vector<std::uint8_t> payload(bounded ? 12 : 4);
  wire::store(std::span(payload), 0, ticket);
  if (bounded) wire::store(std::span(payload), 4, deadline);
  return exchange(wire::FrameType::kWait, now_ps, std::move(payload), ticket, on_progress);
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

Response Link::exchange(wire::FrameType type, std::uint64_t now_ps, std::vector<std::uint8_t> payload,
                        std::uint32_t watched_ticket, const OnProgress& on_progress) {
  Lock lock(mutex_);
  await_credit(lock, payload.size());
  wire::FrameHeader header;
  header.type = type;
  header.id = next_id();
  header.time_ps = now_ps;
  Pending& pending = pending_[header.id];
  pending.type = type;
  pending.watched_ticket = watched_ticket;
  send_with_credit(header, std::move(payload));
  await_response(lock, header.id, on_progress);

  const wire::ErrorCode error = pending.error;
  Response response = std::move(*pending.response);
  pending_.erase(header.id);
  response.error = error;
  if (error == wire::ErrorCode::kNone || error == wire::ErrorCode::kDeadline) return response;
  const std::string text = error_text(response.payload);
  if (ends_session(error)) break_off(text);
  lock.unlock();
  throw_error(error, text);
}

void Link::await_response(Lock& lock, std::uint32_t id, const OnProgress& on_progress) {
  Pending& pending = pending_.at(id);
  try {
    for (;;) {
      await(lock, [&pending] { return pending.response.has_value() || pending.progress.has_value(); });
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
    if (pending.response || phase_ == Phase::kBroken) {
      pending_.erase(id);
    } else {  // the response will still come: it must not be taken for one that was never asked for
      pending.abandoned = true;
      pending.watched_ticket = 0;
    }
    throw;
  }
}

void Link::await_credit(Lock& lock, std::size_t payload) {
  if (payload > agreed_.max_payload_bytes) {
    throw BadArgument("payload", "at most " + std::to_string(agreed_.max_payload_bytes) + " bytes",
                      std::to_string(payload));
  }
  throw_if_broken();
  await(lock, [this, payload] { return send_credits_.can_send(payload); });
}

template <typename Ready>
void Link::await(Lock& lock, const Ready& ready) {
  const auto begin = std::chrono::steady_clock::now();
  while (!ready()) {
    throw_if_broken();
    if (options_.watchdog.count() == 0) {
      changed_.wait(lock);
      continue;
    }
    const auto deadline = std::max(begin, last_heard_) + options_.watchdog;
    if (std::chrono::steady_clock::now() >= deadline) expire();
    changed_.wait_until(lock, deadline);
  }
}

void Link::expire() {
  const std::string text = "no answer of the board within " + std::to_string(options_.watchdog.count()) + " ms";
  break_off(text);
  throw TimedOut(text);
}

void Link::break_off(const std::string& reason) {
  if (phase_ == Phase::kBroken) return;
  phase_ = Phase::kBroken;
  broken_reason_ = reason;
  stream_.close(reason);
  changed_.notify_all();
}

// Only with credit; hands back on the way what has been consumed meanwhile.
void Link::send_with_credit(wire::FrameHeader header, std::vector<std::uint8_t> payload) {
  send_credits_.take(payload.size());
  unreturned_slots_ += 1;
  unreturned_bytes_ += payload.size();
  const auto returned = receive_credits_.give_back();
  header.credit_slots = returned.slots;
  header.credit_bytes = returned.bytes;
  header.sequence = ++sent_;
  stream_.send(header, std::move(payload));
}

// Requests and tickets share the numbers; after 2^32 of them those still in use are passed over.
std::uint32_t Link::next_id() {
  do {
    ++last_id_;
  } while (last_id_ == 0 || pending_.contains(last_id_) || commands_.contains(last_id_));
  return last_id_;
}

void Link::throw_if_broken() const {
  if (phase_ == Phase::kBroken) throw DeviceLost("the board is lost: " + broken_reason_);
}

}  // namespace gicube

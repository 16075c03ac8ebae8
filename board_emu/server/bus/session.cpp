#include "session.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <new>

namespace gicube::emu {

using wire::ErrorCode;
using wire::FrameHeader;
using wire::FrameType;

Session::Session(const Connection::Executor& executor, BoardSlot& slot, const BusOptions& options, std::uint64_t token,
                 const wire::VersionInfo& agreed, const wire::VersionInfo& theirs)
    : slot_(slot),
      options_(options),
      token_(token),
      agreed_(agreed),
      realtime_(slot.realtime()),
      window_(options.version),
      wake_(executor),
      absence_(executor) {
  window_.open(theirs);
}

awaitable<void> Session::run(bool can_resume) {
  const auto self = shared_from_this();
  is_private_ = !can_resume;
  can_resume_ = can_resume && options_.resume_limit.count() > 0;
  try {
    slot_.board().set_minor_version(agreed_.minor);
    co_await work();
  } catch (const LastWord& fault) {
    fail(fault);
  } catch (const std::exception& error) {
    fail(error);
  }
  co_await give_board_back();
}

awaitable<std::string> Session::prepare() {
  if (slot_.has_board()) co_return "";
  std::string why;
  std::function<void()> build = [this, &why] { slot_.renew(why); };
  co_await run_on_compute(std::move(build), false);
  if (why.empty() && stopped_) why = "another client has taken it, or the board process is shutting down";
  co_return why;
}

// ---- connections

// The client's sequence numbers must be consistent with the kept frames: those that it has not taken must still be
// here.
std::string Session::resume_fault(const wire::VersionInfo& theirs) const {
  if (window_.fits(theirs)) return {};
  return fmt::format("expected {} <= consumed <= taken <= {}, got {} and {}", window_.forgotten(), window_.sent(),
                     theirs.consumed, theirs.taken);
}

void Session::attach(Connected connection, std::uint32_t id, const wire::VersionInfo& theirs) {
  if (connection_) connection_->close();  // the client has left it, even if that was not detected
  absence_.cancel();
  slot_.set_away(false);
  const bool is_new = peer_.empty();
  connection_ = std::move(connection);
  peer_ = connection_->peer();
  note(is_new ? AuditEvent::kOpened : AuditEvent::kResumed, is_new ? "a session begins" : "its session continues");

  wire::VersionInfo answer = options_.version;
  answer.session = token_;
  window_.announce(answer);
  connection_->send(FrameHeader{FrameType::kVersion, wire::kResponse, id}, wire::version_payload(answer));
  window_.resume(
      theirs, [this](const FrameHeader& header, const wire::Payload& payload) { connection_->send(header, payload); });
  asio::co_spawn(connection_->executor(), read_frames(shared_from_this(), connection_), asio::detached);
  wake_.cancel();
}

// The connection is no longer usable. The session continues without one for a while.
void Session::lose(const Connected& connection, const std::optional<LastWord>& word) {
  if (word) {
    connection->refuse(*word);
  } else {
    connection->close();
  }
  if (connection_ != connection) return;
  connection_.reset();
  if (stopped_) return;
  if (!can_resume_) return stop();
  absence_.expires_after(options_.resume_limit);
  absence_.async_wait([weak = weak_from_this()](const error_code& cancelled) {
    const auto self = weak.lock();
    if (self && !cancelled && !self->connection_) self->stop();
  });
  slot_.set_away(true);  // done last, because the board may be taken immediately
}

// ---- end

void Session::fail(const std::exception& error) {
  const bool no_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  const char* const why = no_memory ? "the system has no memory left for this request" : error.what();
  spdlog::error("board {}: a session has ended: {}", slot_.index(), why);
  fail({ErrorCode::kInternal, 0, why});
}

awaitable<void> Session::give_board_back() {
  stop();
  note(AuditEvent::kClosed, "the session has ended");
  if (connection_) std::exchange(connection_, nullptr)->close();
  slot_.announce_release();
  try {
    std::function<void()> renew = [this] {
      std::string logged;
      slot_.renew(logged);
    };
    co_await run_on_compute(std::move(renew), false);
  } catch (const std::bad_alloc&) {  // the job could not be posted; no other work is running
    slot_.drop_board();
  }
  slot_.release();
}

void Session::end_for_its_time(std::chrono::milliseconds limit) {
  const double seconds = std::chrono::duration<double>(limit).count();
  note(AuditEvent::kLimitReached, fmt::format("a command of more than {} s", seconds));
  fail({ErrorCode::kTooLarge, 0,
        fmt::format("expected a command that takes at most {} s of this machine's time, got a longer one", seconds)});
}

awaitable<void> Session::run_on_compute(std::function<void()> job, bool shows_progress,
                                        std::chrono::milliseconds limit) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + (limit.count() > 0 ? limit : kUntilWoken);
  job_done_ = false;
  std::exception_ptr fault;
  // The session is passed back to the io thread, because it may only be destroyed there.
  auto run_it = [self = shared_from_this(), executor = wake_.get_executor(), job = std::move(job), &fault]() mutable {
    try {
      job();
    } catch (...) {
      fault = std::current_exception();
    }
    asio::post(executor, [self = std::move(self)] {
      self->job_done_ = true;
      self->wake_.cancel();
    });
  };
  asio::post(slot_.compute(), std::move(run_it));
  while (!job_done_) {
    const Clock::duration interval = shows_progress ? options_.progress_interval : kUntilWoken;
    const Clock::duration left = stopped_ ? interval : std::max(Clock::duration(0), end - Clock::now());
    co_await sleep(wake_, std::min(interval, left));
    if (limit.count() > 0 && !job_done_ && !stopped_ && Clock::now() >= end) end_for_its_time(limit);
    if (shows_progress && !job_done_ && !stopped_) send_progress();
  }
  if (fault) std::rethrow_exception(fault);
}

}  // namespace gicube::emu

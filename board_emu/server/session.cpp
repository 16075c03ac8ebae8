#include "session.h"

#include <fmt/format.h>

#include <array>
#include <exception>

#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

#include "gicube/wire/checksum.h"

namespace gicube::emu {

namespace asio = boost::asio;
using asio::awaitable;
using asio::use_awaitable;
using boost::system::error_code;
using wire::ErrorCode;
using wire::FrameHeader;
using wire::FrameType;

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kForever = std::chrono::hours(24);
constexpr milliseconds kLinger{1000};       // chosen: what a client gets to read the last word
constexpr milliseconds kBusyPatience{200};  // chosen: an owner may just be closing its socket
constexpr milliseconds kClaimInterval{10};  // chosen

}  // namespace

Session::Session(Socket socket, BoardSlot& slot, const BusOptions& options, std::size_t& unowned)
    : socket_(std::move(socket)),
      slot_(slot),
      options_(options),
      unowned_(unowned),
      wake_(socket_.get_executor()),
      deadline_(socket_.get_executor()) {
  ++unowned_;
}

Session::~Session() { count_as_owned(); }

void Session::count_as_owned() {
  if (std::exchange(is_unowned_, false)) --unowned_;
}

awaitable<void> Session::run() {
  const bool owns_board = co_await handshake();
  if (owns_board) {
    reading_ = true;
    asio::co_spawn(socket_.get_executor(), read_frames(shared_from_this()), asio::detached);
    try {
      co_await work();
    } catch (const std::exception& error) {
      fail(ErrorCode::kInternal, 0, error.what());
    }
    co_await give_board_back();
  }
  co_await say_goodbye();
}

void Session::end(ErrorCode error, std::string text) { fail(error, 0, std::move(text)); }

// The first fault is the one that the client hears of.
void Session::fail(ErrorCode error, std::uint32_t id, std::string text) {
  if (!stopped_) last_word_ = LastWord{error, id, std::move(text)};
  stop();
}

void Session::stop() {
  if (stopped_) return;
  stopped_ = true;
  work_.cancel = true;
  wake_.cancel();
  if (!reading_) socket_.cancel();     // in the handshake, or before it
  if (writing_) close_after_linger();  // the client may not be reading
}

// ---- handshake

void Session::watch_handshake() {
  deadline_.expires_after(options_.handshake_deadline);
  deadline_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (cancelled || self->stopped_) return;
    const auto seconds = std::chrono::duration<double>(self->options_.handshake_deadline).count();
    self->fail(ErrorCode::kProtocol, 0, fmt::format("expected a version frame within {} s, got none", seconds));
  });
}

awaitable<bool> Session::handshake() {
  watch_handshake();
  const std::optional<Frame> frame = co_await read_version();
  if (!frame) co_return false;
  const std::uint32_t id = frame->header.id;
  const auto theirs = wire::decode_version(std::span(frame->payload).first<wire::kVersionBytes>());
  const std::optional<wire::VersionInfo> agreed = wire::agree(options_.version, theirs);
  if (!agreed && theirs.major != options_.version.major) {
    fail(ErrorCode::kVersion, id,
         fmt::format("expected major version {}, got {}", options_.version.major, theirs.major));
    co_return false;
  }
  if (!agreed) {
    fail(ErrorCode::kProtocol, id,
         fmt::format(
             "expected max_payload_bytes of at least {}, window_slots of at least 1 and window_bytes of at least "
             "twice the payload limit, got {}, {} and {}",
             wire::kMaxHandshakePayload, theirs.max_payload_bytes, theirs.window_slots, theirs.window_bytes));
    co_return false;
  }
  const bool claimed = co_await claim_board(id);
  if (!claimed) co_return false;
  deadline_.cancel();
  agree_on(*agreed, theirs);
  FrameHeader answer{FrameType::kVersion, wire::kResponse, id};
  std::vector<std::uint8_t> payload(wire::kVersionBytes);
  wire::encode(options_.version, std::span(payload).first<wire::kVersionBytes>());
  co_await write(answer, std::move(payload));
  co_return true;  // the board is ours, even if the client has gone
}

// The client's first frame, if it is what it must be.
awaitable<std::optional<Session::Frame>> Session::read_version() {
  std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
  const error_code header_error = co_await read_exactly(bytes);
  if (header_error) {
    stop();
    co_return std::nullopt;
  }
  const std::optional<FrameHeader> header = wire::decode_frame_header(bytes);
  if (!header || header->type != FrameType::kVersion || header->flags != 0 || header->error != ErrorCode::kNone) {
    fail(ErrorCode::kProtocol, 0, "expected a version frame first, got something else");
    co_return std::nullopt;
  }
  if (header->size > wire::kMaxHandshakePayload) {
    fail(ErrorCode::kTooLarge, header->id,
         fmt::format("expected at most {} payload bytes in the handshake, got {}", wire::kMaxHandshakePayload,
                     header->size));
    co_return std::nullopt;
  }
  if (header->size < wire::kVersionBytes) {
    fail(ErrorCode::kProtocol, header->id,
         fmt::format("expected {} bytes of version payload, got {}", wire::kVersionBytes, header->size));
    co_return std::nullopt;
  }
  Frame frame{*header, std::vector<std::uint8_t>(header->size)};
  const error_code payload_error = co_await read_exactly(frame.payload);
  if (payload_error) {
    stop();
    co_return std::nullopt;
  }
  if (wire::frame_checksum(bytes, frame.payload) != header->checksum) {
    fail(ErrorCode::kCorrupted, header->id,
         fmt::format("expected the checksum 0x{:08x}, got 0x{:08x}", wire::frame_checksum(bytes, frame.payload),
                     header->checksum));
    co_return std::nullopt;
  }
  co_return frame;
}

// Waits for an owner that is about to leave, but not for one that stays.
awaitable<bool> Session::claim_board(std::uint32_t id) {
  const auto patience = std::chrono::steady_clock::now() + kBusyPatience;
  while (!stopped_) {
    const Claim claim = slot_.claim([weak = weak_from_this(), executor = socket_.get_executor()] {
      asio::post(executor, [weak] {
        const auto self = weak.lock();
        if (self) self->end(ErrorCode::kCancelled, "the management plane has reset the board");
      });
    });
    if (claim == Claim::kGranted) {
      count_as_owned();
      co_return true;
    }
    if (claim == Claim::kBusy && std::chrono::steady_clock::now() > patience) {
      fail(ErrorCode::kBusy, id, fmt::format("board {} has an owner", slot_.index()));
      break;
    }
    co_await wait(kClaimInterval);
  }
  co_return false;
}

void Session::agree_on(const wire::VersionInfo& agreed, const wire::VersionInfo& theirs) {
  agreed_ = agreed;
  send_credits_.emplace(theirs.window_slots, theirs.window_bytes);
  receive_credits_.emplace(options_.version.window_slots, options_.version.window_bytes);
}

// ---- end

awaitable<void> Session::give_board_back() {
  stop();
  slot_.announce_release();
  std::function<void()> reset = [this] { slot_.board().reset(); };
  co_await run_on_compute(std::move(reset), false);
  slot_.release();
}

void Session::close_after_linger() {
  deadline_.expires_after(kLinger);
  deadline_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    error_code ignored;
    if (!cancelled) self->socket_.close(ignored);
  });
}

// Sends the last word and reads on until the client closes: closing on unread bytes could take the last word from it.
awaitable<void> Session::say_goodbye() {
  close_after_linger();
  error_code ignored;
  if (last_word_) {
    FrameHeader header{FrameType::kVersion, wire::kResponse, last_word_->id};
    header.error = last_word_->error;
    std::vector<std::uint8_t> text(last_word_->text.begin(), last_word_->text.end());
    co_await write(header, std::move(text));
    socket_.shutdown(Socket::shutdown_send, ignored);
    std::vector<std::uint8_t> scrap(std::size_t{64} << 10);
    error_code ended;
    while (!reading_ && !ended) {
      co_await socket_.async_read_some(asio::buffer(scrap), asio::redirect_error(use_awaitable, ended));
    }
  } else {
    socket_.close(ignored);
  }
  while (reading_) co_await wait(kForever);
  deadline_.cancel();
  socket_.close(ignored);
}

awaitable<void> Session::wait(milliseconds limit) {
  wake_.expires_after(limit);
  error_code ignored;
  co_await wake_.async_wait(asio::redirect_error(use_awaitable, ignored));
}

awaitable<error_code> Session::read_exactly(std::span<std::uint8_t> bytes) {
  error_code error;
  if (stopped_) co_return asio::error::operation_aborted;
  co_await asio::async_read(socket_, asio::buffer(bytes.data(), bytes.size()),
                            asio::redirect_error(use_awaitable, error));
  co_return error;
}

awaitable<std::exception_ptr> Session::run_on_compute(std::function<void()> job, bool shows_progress) {
  job_done_ = false;
  std::exception_ptr fault;
  // The session goes back to the io thread with the news: only there may it end.
  auto run_it = [self = shared_from_this(), executor = socket_.get_executor(), job = std::move(job), &fault]() mutable {
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
    co_await wait(shows_progress ? options_.progress_interval : kForever);
    if (shows_progress && !job_done_ && !stopped_) co_await send_progress();
  }
  co_return fault;
}

}  // namespace gicube::emu

#include "session_acceptor.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <random>

#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace gicube::emu {

namespace asio = boost::asio;
using asio::awaitable;
using boost::system::error_code;
using wire::ErrorCode;
using wire::FrameType;

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kBusyPatience{200};  // chosen: an owner may just be closing its socket
constexpr milliseconds kClaimInterval{10};  // chosen

class PlaceInLine {
 public:
  PlaceInLine(BoardSlot& slot, bool at_head) : slot_(slot), place_(slot.stand_in_line(at_head)) {}
  ~PlaceInLine() { slot_.leave_line(place_); }
  PlaceInLine(const PlaceInLine&) = delete;
  PlaceInLine& operator=(const PlaceInLine&) = delete;
  std::uint64_t number() const { return place_; }

 private:
  BoardSlot& slot_;
  std::uint64_t place_;
};

}  // namespace

class SessionAcceptor::Guest {
 public:
  Guest(SessionAcceptor& acceptor, std::shared_ptr<Connection> connection)
      : acceptor_(acceptor), connection_(std::move(connection)) {
    acceptor_.guests_.push_back(connection_);
  }
  ~Guest() { leave(); }
  Guest(const Guest&) = delete;
  Guest& operator=(const Guest&) = delete;
  void leave() { std::erase(acceptor_.guests_, connection_); }

 private:
  SessionAcceptor& acceptor_;
  std::shared_ptr<Connection> connection_;
};

awaitable<void> SessionAcceptor::receive(std::shared_ptr<Connection> connection, BoardSlot& slot, bool can_resume) {
  Guest guest(*this, connection);
  if (closed_) co_return connection->close();
  if (guests_.size() > options_.max_unowned) {
    connection->refuse({ErrorCode::kBusy, 0, fmt::format("{} connections own no board yet", options_.max_unowned)});
    co_return;
  }
  std::uint32_t id = 0;
  wire::VersionInfo theirs;
  const bool welcome = co_await read_version(*connection, id, theirs);
  if (!welcome) co_return;
  if (theirs.session != 0) co_return resume(connection, slot, id, theirs);

  const std::uint64_t token = new_token();
  const wire::VersionInfo agreed = *wire::agree(options_.version, theirs);
  const auto session = std::make_shared<Session>(connection->executor(), slot, options_, token, agreed, theirs);
  const bool claimed = co_await claim(connection, session, slot, id, theirs);
  if (!claimed) co_return;
  guest.leave();
  sessions_.emplace(token, session);
  session->attach(connection, id, theirs);  // the board is ours, even if the client has gone
  if (closed_) session->end(ErrorCode::kCancelled, "the board shuts down");
  co_await session->run(can_resume);
  sessions_.erase(token);
}

// The client's first frame, if it is what it must be.
awaitable<bool> SessionAcceptor::read_version(Connection& connection, std::uint32_t& id, wire::VersionInfo& theirs) {
  asio::steady_timer deadline(connection.executor(), options_.handshake_deadline);
  const auto come = std::make_shared<bool>(false);
  deadline.async_wait([self = connection.shared_from_this(), come, this](const error_code& cancelled) {
    if (cancelled || *come) return;
    const auto seconds = std::chrono::duration<double>(options_.handshake_deadline).count();
    self->refuse({ErrorCode::kProtocol, 0, fmt::format("expected a version frame within {} s, got none", seconds)});
  });
  Connection::Incoming incoming = co_await connection.read(wire::kMaxHandshakePayload);
  *come = true;
  deadline.cancel();
  if (!connection.is_open()) co_return false;
  if (incoming.fault && incoming.fault->error == ErrorCode::kTooLarge) {
    connection.refuse(*incoming.fault);
    co_return false;
  }
  if (!incoming.frame && !incoming.fault) {
    connection.close();
    co_return false;
  }
  const bool is_version = incoming.frame && incoming.frame->header.type == FrameType::kVersion &&
                          incoming.frame->header.flags == 0 && incoming.frame->header.error == ErrorCode::kNone;
  if (!is_version) {
    const std::string damage = incoming.fault ? ": " + incoming.fault->text : "";
    connection.refuse({ErrorCode::kProtocol, 0, "expected a version frame first, got something else" + damage});
    co_return false;
  }
  id = incoming.frame->header.id;
  const std::vector<std::uint8_t>& payload = incoming.frame->payload;
  if (payload.size() < wire::kVersionBytes) {
    connection.refuse(
        {ErrorCode::kProtocol, id,
         fmt::format("expected {} bytes of version payload, got {}", wire::kVersionBytes, payload.size())});
    co_return false;
  }
  theirs = wire::decode<wire::VersionInfo>(payload);
  if (wire::agree(options_.version, theirs)) co_return true;
  if (theirs.major != options_.version.major) {
    connection.refuse({ErrorCode::kVersion, id,
                       fmt::format("expected major version {}, got {}", options_.version.major, theirs.major)});
    co_return false;
  }
  connection.refuse(
      {ErrorCode::kProtocol, id,
       fmt::format("expected max_payload_bytes of at least {}, window_slots of at least 1 and window_bytes of at least "
                   "twice the payload limit, got {}, {} and {}",
                   wire::kMaxHandshakePayload, theirs.max_payload_bytes, theirs.window_slots, theirs.window_bytes)});
  co_return false;
}

void SessionAcceptor::resume(std::shared_ptr<Connection> connection, BoardSlot& slot, std::uint32_t id,
                             const wire::VersionInfo& theirs) {
  const auto found = sessions_.find(theirs.session);
  if (found == sessions_.end() || found->second->ended() || !found->second->serves(slot)) {
    connection->refuse({ErrorCode::kNoSession, id, "the session to resume has ended, or never was"});
    return;
  }
  const std::string fault = found->second->resume_fault(theirs);
  if (!fault.empty()) return connection->refuse({ErrorCode::kProtocol, id, fault});
  found->second->attach(std::move(connection), id, theirs);
}

// Stands in line. An owner that is about to leave is waited for; one that stays, as long as the client wants.
awaitable<bool> SessionAcceptor::claim(std::shared_ptr<Connection> connection, std::shared_ptr<Session> session,
                                       BoardSlot& slot, std::uint32_t id, const wire::VersionInfo& theirs) {
  Claimant who;
  who.name = connection->peer();
  who.force = (theirs.flags & wire::kForce) != 0;
  who.end_session = [weak = std::weak_ptr(session), executor = connection->executor()](ErrorCode error,
                                                                                       std::string text) {
    asio::post(executor, [weak, error, text = std::move(text)] {
      const auto self = weak.lock();
      if (self) self->end(error, text);
    });
  };
  const PlaceInLine place(slot, who.force);
  who.place = place.number();
  const auto patience = steady_clock::now() + std::max(kBusyPatience, milliseconds(theirs.wait_ms));
  asio::steady_timer timer(connection->executor());
  while (connection->is_open()) {
    const Claim claim = slot.claim(who);
    if (claim == Claim::kGranted) co_return true;
    if (claim == Claim::kBusy && steady_clock::now() > patience) {
      const std::string owner = slot.owner();
      connection->refuse(
          {ErrorCode::kBusy, id,
           fmt::format("board {} has an owner: {}", slot.index(), owner.empty() ? "others wait" : owner)});
      break;
    }
    timer.expires_after(kClaimInterval);
    error_code ignored;
    co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    if (connection->client_has_left()) connection->close();
  }
  co_return false;
}

// Not to be guessed by other clients, for whom it would be the key to this one's session.
std::uint64_t SessionAcceptor::new_token() const {
  std::random_device random;
  for (;;) {
    const std::uint64_t token = std::uint64_t{random()} << 32 | random();
    if (token != 0 && !sessions_.contains(token)) return token;
  }
}

void SessionAcceptor::close() {
  closed_ = true;
  const LastWord word{ErrorCode::kCancelled, 0, "the board shuts down"};
  const auto guests = guests_;
  for (const auto& guest : guests) guest->refuse(word);
  const auto sessions = sessions_;
  for (const auto& [token, session] : sessions) session->end(word.error, word.text);
}

}  // namespace gicube::emu

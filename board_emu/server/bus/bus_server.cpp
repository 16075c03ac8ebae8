#include "bus_server.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <optional>
#include <random>
#include <stdexcept>

#include "listener.h"
#include "words/scope_exit.h"

namespace gicube::emu {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using wire::ErrorCode;
using wire::FrameType;

namespace {

constexpr milliseconds kBusyPatience{200};  // chosen: the owner may be about to close its socket
constexpr milliseconds kClaimInterval{10};  // chosen
constexpr milliseconds kLastWords{300};     // chosen: time for clients to read the final message

std::optional<LastWord> refusal(const Connection::Incoming& incoming, const wire::VersionInfo& ours) {
  if (incoming.fault && incoming.fault->error == ErrorCode::kTooLarge) return incoming.fault;
  const auto& frame = incoming.frame;
  const bool is_version = frame && frame->header.type == FrameType::kVersion && frame->header.flags == 0 &&
                          frame->header.error == ErrorCode::kNone;
  if (!is_version) {
    const std::string damage = incoming.fault ? ": " + incoming.fault->text : "";
    return LastWord{ErrorCode::kProtocol, 0, "expected a version frame first, got another one" + damage};
  }
  const std::uint32_t id = frame->header.id;
  if (frame->payload.size() < wire::kVersionBytes) {
    return LastWord{
        ErrorCode::kProtocol, id,
        fmt::format("expected {} bytes of version payload, got {}", wire::kVersionBytes, frame->payload.size())};
  }
  const wire::VersionInfo theirs = wire::decode<wire::VersionInfo>(frame->payload);
  if (wire::agree(ours, theirs)) return std::nullopt;
  const std::string majors = fmt::format("expected major version {}, got {}", ours.major, theirs.major);
  if (theirs.major != ours.major) return LastWord{ErrorCode::kVersion, id, majors};
  return LastWord{
      ErrorCode::kProtocol, id,
      fmt::format("expected max_payload_bytes of at least {}, window_slots of at least 1 and window_bytes of at least "
                  "twice the payload limit, got {}, {} and {}",
                  wire::kMaxHandshakePayload, theirs.max_payload_bytes, theirs.window_slots, theirs.window_bytes)};
}

}  // namespace

wire::VersionInfo board_version() {
  wire::VersionInfo info;
  info.capabilities = wire::kFunctionalLevel | wire::kProgressFrames | wire::kHostRays;
  return info;
}

BusServer::BusServer(BusOptions options) : options_(std::move(options)) {}

BusServer::~BusServer() = default;

Endpoint BusServer::listen(BoardSlot& slot, const Endpoint& endpoint) {
  try {
    auto listener = std::make_unique<Listener>(*this, slot, endpoint);
    const Endpoint actual = listener->endpoint();
    slot.set_endpoint(to_string(actual));
    slots_.push_back(&slot);
    listener->start();
    listeners_.push_back(std::move(listener));
    return actual;
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error(fmt::format("{}: {}", to_string(endpoint), error.code().message()));
  }
}

void BusServer::adopt(BoardSlot& slot, int fd, bool is_private) {
  int type = 0, accepts = 0;
  socklen_t size = sizeof type;
  sockaddr_storage address{};
  socklen_t address_size = sizeof address;
  const bool is_connected = ::getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_STREAM &&
                            ::getsockopt(fd, SOL_SOCKET, SO_ACCEPTCONN, &accepts, &size) == 0 && accepts == 0 &&
                            ::getpeername(fd, reinterpret_cast<sockaddr*>(&address), &address_size) == 0;
  if (!is_connected) {
    throw std::runtime_error(fmt::format("fd:{}: expected a connected stream socket{}", fd,
                                         is_private ? "" : " or a listening Unix socket"));
  }
  ::fcntl(fd, F_SETFD, FD_CLOEXEC);
  Connection::Socket socket(io_);
  socket.assign(asio::generic::stream_protocol(address.ss_family, 0), fd);
  slot.set_endpoint(fmt::format("fd:{}", fd));
  slots_.push_back(&slot);
  asio::co_spawn(io_, serve(std::move(socket), slot, is_private, false), asio::detached);
}

awaitable<void> BusServer::serve(Connection::Socket socket, BoardSlot& slot, bool is_private, bool wants_token) {
  try {
    const auto connection = std::make_shared<Connection>(std::move(socket), wants_token ? options_.tls.get() : nullptr);
    add(connection);
    note(AuditEvent::kConnected, *connection, fmt::format("board {}", slot.index()));
    co_await receive(connection, slot, !is_private, wants_token);
  } catch (const std::exception& error) {
    spdlog::error("a session ended by a fault of the server: {}", error.what());
  }
  if (is_private) stop_now();
}

// Adds a connection. If too many refused connections do not close, the oldest ones are closed.
void BusServer::add(const std::shared_ptr<Connection>& connection) {
  std::erase_if(connections_, [](const auto& each) { return each.expired(); });
  std::vector<std::shared_ptr<Connection>> leaving;
  for (const auto& each : connections_) {
    if (auto alive = each.lock(); alive && !alive->is_open()) leaving.push_back(std::move(alive));
  }
  for (std::size_t i = 0; i + options_.max_unowned < leaving.size(); ++i) leaving[i]->close();
  connections_.push_back(connection);
}

void BusServer::run() {
  auto alive = asio::make_work_guard(io_);
  while (!stopped_ || !sessions_.empty()) io_.run_one();
  alive.reset();
  io_.run_for(kLastWords);
  for (const auto& each : connections_) {
    if (const auto connection = each.lock()) connection->close();
  }
  io_.run();
  // A compute thread may still be posting to this io context.
  for (BoardSlot* slot : slots_) slot->settle();
}

std::vector<Quota> BusServer::quotas() const {
  std::vector<Quota> quotas{{"connections", std::nullopt, guests_.size(), options_.max_unowned}};
  for (const BoardSlot* slot : slots_) {
    quotas.push_back({"results_bytes", slot->index(), slot->held_bytes(), options_.max_held_bytes});
    if (slot->max_memory_bytes() == kUnlimitedMemory) continue;
    quotas.push_back({"memory_bytes", slot->index(), slot->memory_bytes(), slot->max_memory_bytes()});
  }
  return quotas;
}

void BusServer::stop() {
  asio::post(io_, [this] { stop_now(); });
}

void BusServer::stop_now() {
  if (stopped_) return;
  stopped_ = true;
  for (const auto& listener : listeners_) listener->close();
  const LastWord word{ErrorCode::kCancelled, 0, "the board shuts down"};
  for (const auto& guest : guests_.all()) guest->refuse(word);
  const auto sessions = sessions_;
  for (const auto& [token, session] : sessions) session->end(word.error, word.text);
}

// ---- clients: version frame, queue for a board, session

awaitable<void> BusServer::receive(std::shared_ptr<Connection> connection, BoardSlot& slot, bool can_resume,
                                   bool wants_token) {
  if (stopped_) co_return connection->close();
  if (const auto out = guests_.enter(connection)) {
    turn_away(*out, {ErrorCode::kBusy, 0, "expected a version frame, got none before another client needed its place"});
  }
  const ScopeExit left{[&] { guests_.leave(connection); }};
  std::uint32_t id = 0;
  wire::VersionInfo theirs;
  std::string access_token;
  const bool understood = co_await read_version(*connection, id, theirs, access_token);
  if (!understood) co_return;
  if (wants_token) {
    const bool welcome = co_await may_use(*connection, id, theirs, access_token);
    if (!welcome) co_return;
  }
  if (theirs.session != 0) co_return resume(connection, slot, id, theirs);
  if (const std::string full = guests_.enqueue(connection); !full.empty()) {
    turn_away(*connection, {ErrorCode::kBusy, id, full});
    co_return;
  }

  const std::uint64_t token = new_token();
  const wire::VersionInfo agreed = *wire::agree(options_.version, theirs);
  const auto session = std::make_shared<Session>(connection->executor(), slot, options_, token, agreed, theirs);
  const bool claimed = co_await claim(connection, session, slot, id, theirs);
  if (!claimed) co_return;
  guests_.leave(connection);
  sessions_.emplace(token, session);
  const std::string fault = co_await session->prepare();
  if (!fault.empty()) {
    turn_away(*connection, {ErrorCode::kInternal, id, fmt::format("board {}: {}", slot.index(), fault)});
    sessions_.erase(token);
    slot.release();
    co_return;
  }
  session->attach(connection, id, theirs);  // the session owns the board, even if the client has gone
  if (stopped_) session->end(ErrorCode::kCancelled, "the board shuts down");
  co_await session->run(can_resume);
  sessions_.erase(token);
}

awaitable<bool> BusServer::read_version(Connection& connection, std::uint32_t& id, wire::VersionInfo& theirs,
                                        std::string& token) {
  asio::steady_timer deadline(connection.executor(), options_.handshake_deadline);
  const auto come = std::make_shared<bool>(false);
  deadline.async_wait([self = connection.shared_from_this(), come, this](const error_code& cancelled) {
    if (cancelled || *come) return;
    const auto seconds = std::chrono::duration<double>(options_.handshake_deadline).count();
    turn_away(*self, {ErrorCode::kProtocol, 0, fmt::format("expected a version frame within {} s, got none", seconds)});
  });
  Connection::Incoming incoming = co_await connection.read(wire::kMaxHandshakePayload);
  *come = true;
  deadline.cancel();
  if (!connection.is_open()) co_return false;
  if (!incoming.frame && !incoming.fault) {
    connection.close();
    co_return false;
  }
  if (const auto word = refusal(incoming, options_.version)) {
    turn_away(connection, *word);
    co_return false;
  }
  id = incoming.frame->header.id;
  const std::vector<std::uint8_t>& payload = incoming.frame->payload;
  theirs = wire::decode<wire::VersionInfo>(payload);
  token.assign(payload.begin() + wire::kVersionBytes, payload.end());
  co_return true;
}

// Refuses a client without the right. If the token is wrong, the refusal is delayed, to slow down guessing. Meanwhile
// another connection can take its place.
awaitable<bool> BusServer::may_use(Connection& connection, std::uint32_t id, const wire::VersionInfo& theirs,
                                   const std::string& token) {
  const std::optional<Right> right = right_of(options_.tokens, token);
  const Right needed = (theirs.flags & wire::kForce) != 0 && theirs.session == 0 ? Right::kControl : Right::kUse;
  if (right && *right >= needed) co_return true;
  const auto self = connection.shared_from_this();
  if (right) {
    turn_away(connection,
              {ErrorCode::kForbidden, id,
               fmt::format("expected a token with the right to {}, got one with the right to {}", name_of(needed),
                           name_of(*right))},
              AuditEvent::kForbidden);
    co_return false;
  }
  note(AuditEvent::kUnknown, connection, token.empty() ? "it has no token" : "its token is wrong");
  wrong_tokens_.happened(steady_clock::now());
  const auto has_closed = [&connection] { return !connection.is_open(); };
  co_await sleep_unless(connection.executor(), wrong_tokens_.left(steady_clock::now()), has_closed);
  connection.refuse(
      {ErrorCode::kForbidden, id,
       fmt::format("expected a token of this board, got {}: a program of another user needs one in the file "
                   "that GICUBE_TOKEN_FILE names",
                   token.empty() ? "none" : "another one")});
  co_return false;
}

void BusServer::resume(std::shared_ptr<Connection> connection, BoardSlot& slot, std::uint32_t id,
                       const wire::VersionInfo& theirs) {
  const auto found = sessions_.find(theirs.session);
  if (found == sessions_.end() || found->second->ended() || !found->second->serves(slot)) {
    turn_away(*connection, {ErrorCode::kNoSession, id, "the session to resume has ended, or never was"});
    return;
  }
  const std::string fault = found->second->resume_fault(theirs);
  if (!fault.empty()) return turn_away(*connection, {ErrorCode::kProtocol, id, fault});
  found->second->attach(std::move(connection), id, theirs);
}

// Waits in the queue. If the owner is about to release the board, the client waits; if not, for as long as the client
// wants. A client that may not use force yet is treated like others.
awaitable<bool> BusServer::claim(std::shared_ptr<Connection> connection, std::shared_ptr<Session> session,
                                 BoardSlot& slot, std::uint32_t id, const wire::VersionInfo& theirs) {
  Claimant who;
  who.name = connection->peer();
  const bool wants_force = (theirs.flags & wire::kForce) != 0;
  BackOff& forces = forces_.try_emplace(&slot, options_.force_pause, options_.longest_force_pause).first->second;
  who.force = wants_force && forces.allows(steady_clock::now());
  who.end_session = [weak = std::weak_ptr(session), executor = connection->executor()](ErrorCode error,
                                                                                       std::string text) {
    asio::post(executor, [weak, error, text = std::move(text)] {
      const auto self = weak.lock();
      if (self) self->end(error, text);
    });
  };
  who.place = slot.enqueue(who.force);
  const ScopeExit left{[&] { slot.leave_queue(who.place); }};
  const auto patience =
      steady_clock::now() + std::max(kBusyPatience, std::min(options_.max_wait, milliseconds(theirs.wait_ms)));
  asio::steady_timer timer(connection->executor());
  while (connection->is_open()) {
    const auto now = steady_clock::now();
    who.force = who.force && forces.allows(now);
    const Claim claim = slot.claim(who);
    if (claim == Claim::kGranted) co_return true;
    if (claim == Claim::kForced) {
      forces.happened(now);
      note(AuditEvent::kForced, *connection, fmt::format("board {}: ends another client's session", slot.index()));
    }
    if (claim == Claim::kBusy && now > patience) {
      const std::string owner = slot.owner();
      std::string text = fmt::format("board {} has an owner: {}", slot.index(), owner.empty() ? "others wait" : owner);
      if (const auto left_ms = forces.left(now).count(); wants_force && left_ms > 0) {
        text += fmt::format("; it was recently taken by force, and can be taken again in {:.1f} s",
                            static_cast<double>(left_ms) / 1000);
      }
      turn_away(*connection, {ErrorCode::kBusy, id, std::move(text)});
      break;
    }
    co_await sleep(timer, kClaimInterval);
    if (connection->client_has_left()) connection->close();
  }
  co_return false;
}

// Random, because other clients could otherwise guess it and take over the session.
std::uint64_t BusServer::new_token() const {
  std::random_device random;
  for (;;) {
    const std::uint64_t token = std::uint64_t{random()} << 32 | random();
    if (token != 0 && !sessions_.contains(token)) return token;
  }
}

}  // namespace gicube::emu

// The data plane's sockets, on one io thread: gives each client a session with a board of this process, or a last word.
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include <boost/asio/io_context.hpp>

#include "back_off.h"
#include "board_slot.h"
#include "connection.h"
#include "endpoint.h"
#include "gicube/guests.h"
#include "server/quota.h"
#include "session.h"

namespace gicube::emu {

class BusServer {
 public:
  explicit BusServer(BusOptions options = {});
  // Only before run() or after it has returned.
  ~BusServer();

  BusServer(const BusServer&) = delete;
  BusServer& operator=(const BusServer&) = delete;

  // Before run(). Serves `slot`, which must outlive this; returns the endpoint with its port. Throws std::runtime_error. fd:N is
  // an is_listening() socket: the endpoint is its path, and its file stays when this goes.
  Endpoint listen(BoardSlot& slot, const Endpoint& endpoint);

  // Before run(). Serves `slot` over one connected stream socket; with `is_private` its end stops the server.
  void adopt(BoardSlot& slot, int fd, bool is_private);

  // Serves until stop(); returns when every session has ended and its client had time to read why, with the socket files removed.
  void run();

  // Any thread.
  void stop();

  // Memory of boards that have a limit, results that clients have not fetched, connections without a board. After listen() and adopt();
  // any thread.
  std::vector<Quota> quotas() const;

 private:
  class Listener;

  void stop_now();
  void add(const std::shared_ptr<Connection>& connection);
  awaitable<void> serve(Connection::Socket socket, BoardSlot& slot, bool is_private, bool wants_token);

  // Serves one connection. If it opens a session, returns when that has ended and the board is free again; `can_resume`:
  // the session may go on over other connections. If it resumes one, or is refused, returns at once.
  awaitable<void> receive(std::shared_ptr<Connection> connection, BoardSlot& slot, bool can_resume, bool wants_token);
  awaitable<bool> read_version(Connection& connection, std::uint32_t& id, wire::VersionInfo& theirs,
                               std::string& token);
  awaitable<bool> may_use(Connection& connection, std::uint32_t id, const wire::VersionInfo& theirs,
                          const std::string& token);
  void resume(std::shared_ptr<Connection> connection, BoardSlot& slot, std::uint32_t id,
              const wire::VersionInfo& theirs);
  awaitable<bool> claim(std::shared_ptr<Connection> connection, std::shared_ptr<Session> session, BoardSlot& slot,
                        std::uint32_t id, const wire::VersionInfo& theirs);
  std::uint64_t new_token() const;
  void note(AuditEvent event, const Connection& connection, const std::string& what) const {
    if (options_.audit != nullptr) options_.audit->note(event, connection.peer(), what);
  }
  // Says why, and notes it.
  void turn_away(Connection& connection, const LastWord& word, AuditEvent event = AuditEvent::kRefused) const {
    note(event, connection, word.text);
    connection.refuse(word);
  }

  const BusOptions options_;
  bool stopped_ = false;
  std::vector<std::weak_ptr<Connection>> connections_;  // all of them
  Guests<Connection> guests_{options_.max_unowned, options_.max_unowned_of_peer};
  BackOff wrong_tokens_{options_.token_pause, options_.longest_token_pause};
  std::unordered_map<const BoardSlot*, BackOff> forces_;                  // of boards that were taken by force
  std::unordered_map<std::uint64_t, std::shared_ptr<Session>> sessions_;  // by token
  asio::io_context io_{1};
  std::vector<BoardSlot*> slots_;  // those that were served
  std::vector<std::unique_ptr<Listener>> listeners_;
};

}  // namespace gicube::emu

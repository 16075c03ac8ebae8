// Sockets of the data plane, on one io thread. Each client gets a session with a board of this process, or an error
// message.
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
  // Must be called before run() or after it has returned.
  ~BusServer();

  BusServer(const BusServer&) = delete;
  BusServer& operator=(const BusServer&) = delete;

  // Call before run(). Serves `slot`, which must outlive this object; returns the endpoint with its port. Throws
  // std::runtime_error. fd:N must be an is_listening() socket: the endpoint is its path, and its file is not removed.
  Endpoint listen(BoardSlot& slot, const Endpoint& endpoint);

  // Call before run(). Serves `slot` over one connected stream socket. With `is_private`, its end stops the server.
  void adopt(BoardSlot& slot, int fd, bool is_private);

  // Serves until stop(). Returns after all sessions have ended and their clients had time to read the reason. Socket
  // files are then removed.
  void run();

  // Thread-safe.
  void stop();

  // Memory of boards with a limit, results that clients have not fetched, connections without a board. Call after
  // listen() and adopt(). Thread-safe.
  std::vector<Quota> quotas() const;

 private:
  class Listener;

  void stop_now();
  void add(const std::shared_ptr<Connection>& connection);
  awaitable<void> serve(Connection::Socket socket, BoardSlot& slot, bool is_private, bool wants_token);

  // Serves one connection. If it opens a session, this returns when the session has ended and the board is free again.
  // If it resumes one, or is refused, this returns at once. `can_resume`: the session may continue over other
  // connections.
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
  // Sends the reason to the client and notes it in the audit log.
  void turn_away(Connection& connection, const LastWord& word, AuditEvent event = AuditEvent::kRefused) const {
    note(event, connection, word.text);
    connection.refuse(word);
  }

  const BusOptions options_;
  bool stopped_ = false;
  std::vector<std::weak_ptr<Connection>> connections_;  // all connections
  Guests<Connection> guests_{options_.max_unowned, options_.max_unowned_of_peer};
  BackOff wrong_tokens_{options_.token_pause, options_.longest_token_pause};
  std::unordered_map<const BoardSlot*, BackOff> forces_;                  // for boards that were taken by force
  std::unordered_map<std::uint64_t, std::shared_ptr<Session>> sessions_;  // by token
  asio::io_context io_{1};
  std::vector<BoardSlot*> slots_;  // all slots that are served
  std::vector<std::unique_ptr<Listener>> listeners_;
};

}  // namespace gicube::emu

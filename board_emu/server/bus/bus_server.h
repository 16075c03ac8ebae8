// The data plane's sockets: accepts connections for the boards of this process, on one io thread, and gives each client its
// session. A client that is refused gets a last word.
#pragma once

#include <initializer_list>
#include <memory>
#include <unordered_map>
#include <utility>  // Boost 1.74's awaitable.hpp uses std::exchange without it
#include <vector>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>

#include "board_slot.h"
#include "connection.h"
#include "endpoint.h"
#include "session.h"

namespace gicube::emu {

class BusServer {
 public:
  explicit BusServer(BusOptions options = {});
  // Only before run() or after it has returned.
  ~BusServer();

  BusServer(const BusServer&) = delete;
  BusServer& operator=(const BusServer&) = delete;

  // Before run(). Serves `slot`, which must outlive this, on a unix or tcp endpoint; returns the endpoint with the port
  // that it got. Throws std::runtime_error that names the endpoint.
  Endpoint listen(BoardSlot& slot, const Endpoint& endpoint);

  // Before run(). Serves `slot` over one connected stream socket; with `is_private` its end stops the server.
  void adopt(BoardSlot& slot, int fd, bool is_private);

  // Before run(): these signals stop the server.
  void stop_on_signals(std::initializer_list<int> signals);

  // Serves until stop(); returns when every session has ended, with its socket files removed.
  void run();

  // Any thread.
  void stop();

 private:
  class Listener;

  void welcome(Connection::Socket socket, BoardSlot& slot, bool is_private);
  void stop_now();
  boost::asio::awaitable<void> serve(std::shared_ptr<Connection> connection, BoardSlot& slot, bool is_private);

  // Serves one connection. If it opens a session, returns when that has ended and the board is free again; `can_resume`:
  // the session may go on over other connections. If it resumes one, or is refused, returns at once.
  boost::asio::awaitable<void> receive(std::shared_ptr<Connection> connection, BoardSlot& slot, bool can_resume);
  boost::asio::awaitable<bool> read_version(Connection& connection, std::uint32_t& id, wire::VersionInfo& theirs);
  void resume(std::shared_ptr<Connection> connection, BoardSlot& slot, std::uint32_t id,
              const wire::VersionInfo& theirs);
  boost::asio::awaitable<bool> claim(std::shared_ptr<Connection> connection, std::shared_ptr<Session> session,
                                     BoardSlot& slot, std::uint32_t id, const wire::VersionInfo& theirs);
  std::uint64_t new_token() const;
  void send_away();

  const BusOptions options_;
  bool stopped_ = false;
  std::vector<std::shared_ptr<Connection>> guests_;                       // that own no board yet
  std::unordered_map<std::uint64_t, std::shared_ptr<Session>> sessions_;  // by token
  boost::asio::io_context io_{1};
  boost::asio::signal_set signals_{io_};
  std::vector<BoardSlot*> slots_;  // those that were served
  std::vector<std::unique_ptr<Listener>> listeners_;
};

}  // namespace gicube::emu

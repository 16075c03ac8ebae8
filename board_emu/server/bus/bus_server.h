// The data plane's sockets: accepts connections for the boards of this process, on one io thread.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>

#include "board_slot.h"
#include "endpoint.h"
#include "session_acceptor.h"

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

  const BusOptions options_;
  SessionAcceptor acceptor_;
  bool stopped_ = false;
  boost::asio::io_context io_{1};
  boost::asio::signal_set signals_{io_};
  std::vector<BoardSlot*> slots_;  // those that were served
  std::vector<std::unique_ptr<Listener>> listeners_;
};

}  // namespace gicube::emu

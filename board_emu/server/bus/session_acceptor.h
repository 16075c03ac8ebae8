// Meets the clients of the data plane: their version frame, their place in line for a board, their session.
//
// A client that is refused gets a last word. Everything here runs on the server's io thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>  // Boost 1.74's awaitable.hpp uses std::exchange without it
#include <vector>

#include <boost/asio/awaitable.hpp>

#include "board_slot.h"
#include "connection.h"
#include "session.h"

namespace gicube::emu {

class SessionAcceptor {
 public:
  // `options` must outlive it.
  explicit SessionAcceptor(const BusOptions& options) : options_(options) {}

  // Serves one connection. If it opens a session, returns when that has ended and the board is free again; `can_resume`:
  // the session may go on over other connections. If it resumes one, or is refused, returns at once.
  boost::asio::awaitable<void> receive(std::shared_ptr<Connection> connection, BoardSlot& slot, bool can_resume);

  // The board shuts down: sends everyone away, now and later.
  void close();

 private:
  class Guest;  // a connection that owns no board yet

  boost::asio::awaitable<bool> read_version(Connection& connection, std::uint32_t& id, wire::VersionInfo& theirs);
  void resume(std::shared_ptr<Connection> connection, BoardSlot& slot, std::uint32_t id,
              const wire::VersionInfo& theirs);
  boost::asio::awaitable<bool> claim(std::shared_ptr<Connection> connection, std::shared_ptr<Session> session,
                                     BoardSlot& slot, std::uint32_t id, const wire::VersionInfo& theirs);
  std::uint64_t new_token() const;

  const BusOptions& options_;
  bool closed_ = false;
  std::vector<std::shared_ptr<Connection>> guests_;
  std::unordered_map<std::uint64_t, std::shared_ptr<Session>> sessions_;  // by token
};

}  // namespace gicube::emu

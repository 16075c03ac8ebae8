// This process's socket in its user's registry (proto/gicube/registry.h). gicube-smi finds the process by it, also
// without a management plane.
#pragma once

#include <string>
#include <thread>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>

#include "server/audit.h"
#include "server/bus/board_slot.h"
#include "server/bus/coroutines.h"
#include "server/quota.h"

namespace gicube::emu {

class Registration {
 public:
  // Creates the folder if necessary, and reports the boards, which must outlive this object, to clients from a separate
  // thread. `management`: endpoint of the management plane, or empty. `audit`: source of event counts; may be null.
  // `quotas`: source of limits; may be empty. Throws std::runtime_error with the reason if the socket cannot be
  // created.
  Registration(std::string management, std::vector<BoardSlot*> boards, const Audit* audit = nullptr,
               Quotas quotas = {});
  // Removes the socket.
  ~Registration();

  Registration(const Registration&) = delete;
  Registration& operator=(const Registration&) = delete;

  const std::string& path() const { return path_; }

 private:
  using Socket = asio::local::stream_protocol::socket;

  awaitable<void> accept();
  awaitable<void> send_message(Socket caller) const;
  std::string message() const;

  const std::string management_;
  const std::vector<BoardSlot*> boards_;
  const Audit* const audit_;
  const Quotas quotas_;
  std::string path_;
  asio::io_context io_{1};
  asio::local::stream_protocol::acceptor acceptor_{io_};
  std::thread thread_;
};

}  // namespace gicube::emu

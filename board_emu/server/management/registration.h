// This process's socket in its user's registry (proto/gicube/registry.h), by which gicube-smi finds it, management plane or not.
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
  // Makes the folder if it is not there, and tells callers about the boards, which must outlive this, from a thread of its own.
  // `management`: the endpoint of their management plane, or empty. Throws std::runtime_error that says why nobody will see them.
  // `audit`: whose counts are told too; null: none. `quotas`: what to tell of limits; empty: nothing.
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
  awaitable<void> tell(Socket caller) const;
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

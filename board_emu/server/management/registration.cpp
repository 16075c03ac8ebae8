#include "registration.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <boost/asio/write.hpp>

#include "describe.h"
#include "gicube/registry.h"

namespace gicube::emu {
namespace {

constexpr std::chrono::milliseconds kAcceptRetry{100};  // chosen: until file descriptors may be available again

}  // namespace

Registration::Registration(std::string management, std::vector<BoardSlot*> boards, const Audit* audit, Quotas quotas)
    : management_(std::move(management)), boards_(std::move(boards)), audit_(audit), quotas_(std::move(quotas)) {
  const std::string folder = open_registry();
  remove_dead_sockets(folder);
  path_ = folder + '/' + std::to_string(::getpid());
  // The socket is renamed when it answers, because readers assume that a socket that refuses connections belongs to a
  // dead process.
  const std::string unnamed = folder + "/." + std::to_string(::getpid());
  const auto fail = [&unnamed](const std::string& path, const std::error_code& error) {
    ::unlink(unnamed.c_str());
    throw std::runtime_error(path + ": " + error.message());
  };
  try {
    const asio::local::stream_protocol::endpoint endpoint(unnamed);
    ::unlink(unnamed.c_str());
    acceptor_.open(endpoint.protocol());
    acceptor_.bind(endpoint);
    acceptor_.listen();
  } catch (const boost::system::system_error& error) {
    fail(unnamed, error.code());
  }
  if (std::rename(unnamed.c_str(), path_.c_str()) != 0) fail(path_, {errno, std::generic_category()});
  asio::co_spawn(io_, accept(), asio::detached);
  thread_ = std::thread([this] { io_.run(); });
}

Registration::~Registration() {
  ::unlink(path_.c_str());
  io_.stop();
  thread_.join();
}

awaitable<void> Registration::accept() {
  asio::steady_timer pause(io_);
  for (;;) {
    Socket caller(io_);
    error_code error;
    co_await acceptor_.async_accept(caller, into(error));
    if (error) {
      co_await sleep(pause, kAcceptRetry);
    } else {
      asio::co_spawn(io_, send_message(std::move(caller)), asio::detached);
    }
  }
}

awaitable<void> Registration::send_message(Socket caller) const {
  const std::string bytes = message();
  error_code gone;
  co_await asio::async_write(caller, asio::buffer(bytes), into(gone));
}

std::string Registration::message() const {
  v1::BoardProcess process;
  process.set_pid(static_cast<std::uint32_t>(::getpid()));
  process.set_management_endpoint(management_);
  for (BoardSlot* slot : boards_) {
    describe(std::as_const(*slot), *process.add_boards());
    describe(std::as_const(*slot), *process.add_counters());
  }
  for (const Audit::Count& each : audit_ != nullptr ? audit_->counts() : std::vector<Audit::Count>()) {
    v1::AuditCount* added = process.add_events();
    added->set_event(each.event);
    added->set_count(each.count);
  }
  for (const Quota& each : quotas_ ? quotas_() : std::vector<Quota>()) {
    v1::Quota* added = process.add_quotas();
    added->set_name(each.name);
    if (each.board) added->set_board(*each.board);
    added->set_used(each.used);
    added->set_limit(each.limit);
  }
  return process.SerializeAsString();
}

}  // namespace gicube::emu

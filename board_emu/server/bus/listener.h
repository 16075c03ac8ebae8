// A listening socket of the bus server. Included only by bus_server.cpp.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

#include <boost/asio/basic_socket_acceptor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>

#include "bus_server.h"

namespace gicube::emu {

inline constexpr std::chrono::milliseconds kAcceptPause{100};  // chosen: until file descriptors may be available again

// Identity of the file at `path`, so that a file that has replaced ours is not removed.
inline std::pair<dev_t, ino_t> identity(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino};
}

// Disables the delay of small frames, and enables detection of clients that have disappeared without closing, for
// example with their machine.
inline void prepare(Connection::Socket& socket) {
  constexpr int kIdleSeconds = 30, kIntervalSeconds = 10, kProbes = 3;  // chosen: a client is gone after a minute
  error_code ignored;
  socket.set_option(asio::ip::tcp::no_delay(true), ignored);
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  for (const auto& [name, value] : {std::pair(TCP_KEEPIDLE, kIdleSeconds), std::pair(TCP_KEEPINTVL, kIntervalSeconds),
                                    std::pair(TCP_KEEPCNT, kProbes)}) {
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, name, &value, sizeof value);
  }
}

// Unix and TCP sockets with a generic protocol, because they do not differ after binding.
class BusServer::Listener {
 public:
  Listener(BusServer& server, BoardSlot& slot, const Endpoint& endpoint)
      : server_(server), slot_(slot), endpoint_(endpoint), pause_(server.io_) {
    if (endpoint.kind == EndpointKind::kUnix) {
      remove_stale_socket(endpoint_.path);
      bind(asio::local::stream_protocol::endpoint(endpoint_.path));
      file_ = identity(endpoint_.path);
      ::chmod(endpoint_.path.c_str(), S_IRUSR | S_IWUSR);
    } else if (endpoint.kind == EndpointKind::kFd) {
      take_over(endpoint.fd);
      return;
    } else {
      bind(asio::ip::tcp::endpoint(asio::ip::make_address(endpoint_.address), endpoint_.port));
      asio::ip::tcp::endpoint bound;
      const auto generic = acceptor_.local_endpoint();
      std::memcpy(bound.data(), generic.data(), generic.size());
      endpoint_.port = bound.port();
      endpoint_.is_secure = server.options_.tls != nullptr;
    }
    acceptor_.listen();
  }

  ~Listener() { close(); }

  const Endpoint& endpoint() const { return endpoint_; }

  void start() { asio::co_spawn(server_.io_, accept(), asio::detached); }

  void close() {
    if (!acceptor_.is_open()) return;
    error_code ignored;
    pause_.cancel();
    if (file_ && identity(endpoint_.path) == *file_) ::unlink(endpoint_.path.c_str());
    acceptor_.close(ignored);
  }

 private:
  void bind(const asio::generic::stream_protocol::endpoint& endpoint) {
    acceptor_.open(endpoint.protocol());
    acceptor_.set_option(asio::socket_base::reuse_address(true));
    acceptor_.bind(endpoint);
  }

  void take_over(int fd) {
    if (!is_listening(fd)) throw std::runtime_error(fmt::format("fd:{}: expected a listening Unix socket", fd));
    ::fcntl(fd, F_SETFD, FD_CLOEXEC);
    acceptor_.assign(asio::generic::stream_protocol(AF_UNIX, 0), fd);
    sockaddr_un address{};
    socklen_t size = sizeof address;
    ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
    const std::string path(address.sun_path, ::strnlen(address.sun_path, sizeof address.sun_path));
    if (!path.empty()) endpoint_ = {EndpointKind::kUnix, path, "", 0, -1};  // otherwise unnamed or abstract
  }

  awaitable<void> accept() {
    while (acceptor_.is_open()) {
      Connection::Socket socket(server_.io_);
      error_code error;
      co_await acceptor_.async_accept(socket, into(error));
      if (!acceptor_.is_open()) break;
      if (error) {
        spdlog::warn("{}: {}", to_string(endpoint_), error.message());
        co_await sleep(pause_, kAcceptPause);
        continue;
      }
      const bool is_tcp = endpoint_.kind == EndpointKind::kTcp;
      if (is_tcp) prepare(socket);
      asio::co_spawn(server_.io_, server_.serve(std::move(socket), slot_, false, is_tcp), asio::detached);
    }
  }

  BusServer& server_;
  BoardSlot& slot_;
  Endpoint endpoint_;
  std::optional<std::pair<dev_t, ino_t>> file_;  // to be removed at the end
  asio::basic_socket_acceptor<asio::generic::stream_protocol> acceptor_{server_.io_};
  asio::steady_timer pause_;
};

}  // namespace gicube::emu

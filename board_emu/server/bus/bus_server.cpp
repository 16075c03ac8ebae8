#include "bus_server.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <stdexcept>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace gicube::emu {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

constexpr std::chrono::milliseconds kAcceptPause{100};  // chosen: until descriptors may be free again

// Which file is at `path`, so that one that has taken our place is left alone.
std::pair<dev_t, ino_t> identity(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino};
}

}  // namespace

wire::VersionInfo board_version() {
  wire::VersionInfo info;
  info.capabilities = wire::kFunctionalLevel | wire::kProgressFrames | wire::kHostRays;
  return info;
}

// Either acceptor of Asio as one of generic protocol: after bind() they no longer differ.
class BusServer::Listener {
 public:
  Listener(BusServer& server, BoardSlot& slot, const Endpoint& endpoint)
      : server_(server), slot_(slot), endpoint_(endpoint), pause_(server.io_) {
    if (endpoint.kind == EndpointKind::kUnix) {
      open_unix();
    } else {
      open_tcp();
    }
  }

  ~Listener() { close(); }

  const Endpoint& endpoint() const { return endpoint_; }

  void start() {
    if (unix_.is_open()) asio::co_spawn(server_.io_, accept_on(unix_), asio::detached);
    if (tcp_.is_open()) asio::co_spawn(server_.io_, accept_on(tcp_), asio::detached);
  }

  void close() {
    error_code ignored;
    pause_.cancel();
    tcp_.close(ignored);
    if (!unix_.is_open()) return;
    if (identity(endpoint_.path) == file_) ::unlink(endpoint_.path.c_str());
    unix_.close(ignored);
  }

 private:
  void open_unix() {
    remove_stale_socket(endpoint_.path);
    unix_.open();
    unix_.bind(asio::local::stream_protocol::endpoint(endpoint_.path));
    file_ = identity(endpoint_.path);
    ::chmod(endpoint_.path.c_str(), S_IRUSR | S_IWUSR);
    unix_.listen();
  }

  void open_tcp() {
    const asio::ip::tcp::endpoint address(asio::ip::make_address(endpoint_.address), endpoint_.port);
    tcp_.open(address.protocol());
    tcp_.set_option(asio::socket_base::reuse_address(true));
    tcp_.bind(address);
    tcp_.listen();
    endpoint_.port = tcp_.local_endpoint().port();
  }

  template <typename Acceptor>
  asio::awaitable<void> accept_on(Acceptor& acceptor) {
    while (acceptor.is_open()) {
      typename Acceptor::protocol_type::socket socket(server_.io_);
      error_code error;
      co_await acceptor.async_accept(socket, asio::redirect_error(asio::use_awaitable, error));
      if (!acceptor.is_open()) break;
      if (error) {
        spdlog::warn("{}: {}", to_string(endpoint_), error.message());
        pause_.expires_after(kAcceptPause);
        co_await pause_.async_wait(asio::redirect_error(asio::use_awaitable, error));
        continue;
      }
      error_code ignored;
      if constexpr (std::is_same_v<typename Acceptor::protocol_type, asio::ip::tcp>) {
        socket.set_option(asio::ip::tcp::no_delay(true), ignored);
      }
      server_.welcome(Connection::Socket(std::move(socket)), slot_, false);
    }
  }

  BusServer& server_;
  BoardSlot& slot_;
  Endpoint endpoint_;
  std::pair<dev_t, ino_t> file_{};
  asio::local::stream_protocol::acceptor unix_{server_.io_};
  asio::ip::tcp::acceptor tcp_{server_.io_};
  asio::steady_timer pause_;
};

BusServer::BusServer(BusOptions options) : options_(std::move(options)), acceptor_(options_) {}

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
                            ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &address_size) == 0;
  if (!is_connected) throw std::runtime_error(fmt::format("fd:{}: expected a connected stream socket", fd));
  ::fcntl(fd, F_SETFD, FD_CLOEXEC);
  Connection::Socket socket(io_);
  socket.assign(asio::generic::stream_protocol(address.ss_family, 0), fd);
  slot.set_endpoint(fmt::format("fd:{}", fd));
  slots_.push_back(&slot);
  welcome(std::move(socket), slot, is_private);
}

void BusServer::welcome(Connection::Socket socket, BoardSlot& slot, bool is_private) {
  auto connection = std::make_shared<Connection>(std::move(socket));
  asio::co_spawn(io_, serve(std::move(connection), slot, is_private), asio::detached);
}

asio::awaitable<void> BusServer::serve(std::shared_ptr<Connection> connection, BoardSlot& slot, bool is_private) {
  try {
    co_await acceptor_.receive(std::move(connection), slot, !is_private);
  } catch (const std::exception& error) {
    spdlog::error("a session ended by a fault of the server: {}", error.what());
  }
  if (is_private) stop_now();
}

void BusServer::stop_on_signals(std::initializer_list<int> signals) {
  for (const int signal : signals) signals_.add(signal);
  signals_.async_wait([this](const error_code& cancelled, int) {
    if (!cancelled) stop_now();
  });
}

void BusServer::run() {
  auto alive = asio::make_work_guard(io_);
  while (!stopped_) io_.run_one();
  alive.reset();
  io_.run();  // until the last session has ended
  // A compute thread may still be on its way out of telling this io context so.
  for (BoardSlot* slot : slots_) slot->settle();
}

void BusServer::stop() {
  asio::post(io_, [this] { stop_now(); });
}

void BusServer::stop_now() {
  if (stopped_) return;
  stopped_ = true;
  signals_.cancel();
  for (const auto& listener : listeners_) listener->close();
  acceptor_.close();
}

}  // namespace gicube::emu

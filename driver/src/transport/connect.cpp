#include "connect.h"

#include <fcntl.h>
#include <sys/un.h>

#include <functional>
#include <string>
#include <utility>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>

#include "gicube/error.h"

namespace gicube {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// Runs one connection attempt, which calls its argument when it is done.
void run(asio::io_context& io, std::chrono::milliseconds watchdog, const std::string& where,
         const std::function<void(std::function<void(error_code)>)>& attempt) {
  error_code result = asio::error::would_block;
  attempt([&result](error_code error) { result = error; });
  if (watchdog.count() == 0) {
    io.run();
  } else {
    io.run_for(watchdog);
  }
  if (result == asio::error::would_block) {
    throw TimedOut("no connection to " + where + " within " + std::to_string(watchdog.count()) + " ms");
  }
  if (result) throw OpenFailed("cannot connect to " + where + ": " + result.message());
}

Fd connect_unix(const std::string& path, std::chrono::milliseconds watchdog) {
  constexpr std::size_t kLongest = sizeof(sockaddr_un::sun_path) - 1;
  if (path.size() > kLongest) {
    throw BadArgument("URI path", "at most " + std::to_string(kLongest) + " bytes", std::to_string(path.size()));
  }
  asio::io_context io;
  asio::local::stream_protocol::socket socket(io);
  run(io, watchdog, "unix:" + path, [&](std::function<void(error_code)> done) {
    socket.async_connect(asio::local::stream_protocol::endpoint(path), std::move(done));
  });
  return Fd(socket.release());
}

Fd connect_tcp(const std::string& host, std::uint16_t port, std::chrono::milliseconds watchdog) {
  const std::string where = "tcp:" + host + ":" + std::to_string(port);
  asio::io_context io;
  asio::ip::tcp::socket socket(io);
  error_code error;
  const auto endpoints = asio::ip::tcp::resolver(io).resolve(host, std::to_string(port), error);
  if (error) throw OpenFailed("cannot connect to " + where + ": " + error.message());
  run(io, watchdog, where, [&](std::function<void(error_code)> done) {
    asio::async_connect(socket, endpoints, [done = std::move(done)](error_code result, const auto&) { done(result); });
  });
  // Requests are small and each waits for its answer: they must not wait for company too.
  socket.set_option(asio::ip::tcp::no_delay(true), error);
  return Fd(socket.release());
}

}  // namespace

Fd connect(const Uri& uri, std::chrono::milliseconds watchdog) {
  Fd socket =
      uri.scheme == UriScheme::kTcp ? connect_tcp(uri.host, uri.port, watchdog) : connect_unix(uri.path, watchdog);
  ::fcntl(socket.get(), F_SETFD, FD_CLOEXEC);
  return socket;
}

}  // namespace gicube

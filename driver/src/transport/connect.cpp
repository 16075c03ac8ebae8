#include "connect.h"

#include <fcntl.h>
#include <sys/un.h>

#include <string>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>

#include "gicube/error.h"

namespace gicube {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// Until the attempt that was begun sets `result`, or the time is over.
void run(asio::io_context& io, std::chrono::milliseconds watchdog) {
  if (watchdog.count() == 0) {
    io.run();
  } else {
    io.run_for(watchdog);
  }
}

Fd connect_unix(const std::string& path, std::chrono::milliseconds watchdog, error_code& result) {
  constexpr std::size_t kLongest = sizeof(sockaddr_un::sun_path) - 1;
  if (path.size() > kLongest) {
    throw BadArgument("URI path", "at most " + std::to_string(kLongest) + " bytes", std::to_string(path.size()));
  }
  asio::io_context io;
  asio::local::stream_protocol::socket socket(io);
  socket.async_connect(path, [&result](error_code error) { result = error; });
  run(io, watchdog);
  return Fd(socket.release());
}

Fd connect_tcp(const Uri& uri, std::chrono::milliseconds watchdog, error_code& result) {
  asio::io_context io;
  asio::ip::tcp::socket socket(io);
  error_code error;
  const auto endpoints = asio::ip::tcp::resolver(io).resolve(uri.host, std::to_string(uri.port), error);
  if (error) {
    result = error;
    return {};
  }
  asio::async_connect(socket, endpoints, [&result](error_code failed, const auto&) { result = failed; });
  run(io, watchdog);
  // Requests are small and each waits for its answer: they must not wait for company too.
  socket.set_option(asio::ip::tcp::no_delay(true), error);
  return Fd(socket.release(error));
}

}  // namespace

Fd try_to_connect(const Uri& uri, std::chrono::milliseconds watchdog, error_code& result) {
  result = asio::error::would_block;
  Fd socket =
      uri.scheme == UriScheme::kTcp ? connect_tcp(uri, watchdog, result) : connect_unix(uri.path, watchdog, result);
  ::fcntl(socket.get(), F_SETFD, FD_CLOEXEC);
  return socket;
}

Fd connect(const Uri& uri, std::chrono::milliseconds watchdog) {
  error_code result;
  Fd socket = try_to_connect(uri, watchdog, result);
  if (!result) return socket;
  const std::string where =
      uri.scheme == UriScheme::kTcp ? "tcp:" + uri.host + ":" + std::to_string(uri.port) : "unix:" + uri.path;
  if (result == asio::error::would_block) {
    throw TimedOut("no connection to " + where + " within " + std::to_string(watchdog.count()) + " ms");
  }
  throw OpenFailed("cannot connect to " + where + ": " + result.message());
}

}  // namespace gicube

#include "connect.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/un.h>

#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <vector>

#include <boost/asio/connect.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>

#include "gicube/access.h"
#include "gicube/error.h"

namespace gicube {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

std::vector<asio::generic::stream_protocol::endpoint> endpoints_of(const Uri& uri, asio::io_context& io,
                                                                   error_code& error) {
  constexpr std::size_t kLongest = sizeof(sockaddr_un::sun_path) - 1;
  if (uri.path.size() > kLongest) {
    throw BadArgument("URI path", fmt::format("at most {} bytes", kLongest), fmt::format("{}", uri.path.size()));
  }
  if (uri.scheme == UriScheme::kUnix) return {asio::local::stream_protocol::endpoint(uri.path)};
  std::vector<asio::generic::stream_protocol::endpoint> endpoints;
  for (const auto& found : asio::ip::tcp::resolver(io).resolve(uri.host, std::to_string(uri.port), error)) {
    endpoints.emplace_back(found.endpoint());
  }
  return endpoints;
}

}  // namespace

Fd try_to_connect(const Uri& uri, std::chrono::milliseconds watchdog, error_code& result) {
  asio::io_context io;
  asio::generic::stream_protocol::socket socket(io);
  result.clear();
  const auto endpoints = endpoints_of(uri, io, result);
  if (result) return {};
  result = asio::error::would_block;
  asio::async_connect(socket, endpoints, [&result](error_code failed, const auto&) { result = failed; });
  if (watchdog.count() == 0) {
    io.run();
  } else {
    io.run_for(watchdog);
  }
  error_code ignored;
  if (uri.scheme == UriScheme::kTcp) {
    // Requests are small, and each waits for its answer: they are sent at once instead of being collected.
    socket.set_option(asio::ip::tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::keep_alive(true), ignored);  // detects a dead machine after two hours
  }
  Fd connected(socket.release(ignored));
  ::fcntl(connected.get(), F_SETFD, FD_CLOEXEC);
  return connected;
}

Fd connect(const Uri& uri, std::chrono::milliseconds watchdog) {
  error_code result;
  Fd socket = try_to_connect(uri, watchdog, result);
  if (!result) return socket;
  const std::string where = text_of(uri);
  if (result != asio::error::would_block) throw OpenFailed("cannot connect to " + where + ": " + result.message());
  throw TimedOut(fmt::format("no connection to {} within {} ms", where, watchdog.count()));
}

NamedFile named_file(const std::string& option, const char* field, const char* variable) {
  if (!option.empty()) return {option, field};
  const char* const named = std::getenv(variable);
  return {named != nullptr ? named : "", variable};
}

std::string named_token(const std::string& token_file) {
  const auto [path, field] = named_file(token_file, "token_file", "GICUBE_TOKEN_FILE");
  if (path.empty()) return {};
  try {
    return read_tokens(path).front().token;
  } catch (const std::runtime_error& error) {
    throw BadArgument(field, "a file with a token", error.what());
  }
}

std::string access_token(int socket, bool is_secure, const std::string& token_file) {
  const std::string named = named_token(token_file);
  asio::ip::tcp::endpoint peer;
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  const bool known = ::getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  if (!known || (address.ss_family != AF_INET && address.ss_family != AF_INET6)) return {};
  std::memcpy(peer.data(), &address, size);
  peer.resize(size);
  if (!is_secure && !peer.address().is_loopback()) return {};
  return named.empty() ? local_token(peer.address().to_string(), peer.port()) : named;
}

}  // namespace gicube

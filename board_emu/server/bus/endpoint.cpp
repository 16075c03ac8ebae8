#include "endpoint.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/ip/address.hpp>
#include <charconv>
#include <stdexcept>

#include "gicube/registry.h"

namespace gicube::emu {
namespace {

template <typename T>
bool parse_number(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

[[noreturn]] void refuse(std::string_view text, std::string_view expected) {
  throw std::invalid_argument(fmt::format("expected {}, got \"{}\"", expected, text));
}

Endpoint parse_tcp(std::string_view text, std::string_view rest) {
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string_view::npos) refuse(text, "tcp:HOST:PORT");
  std::string_view host = rest.substr(0, colon);
  Endpoint endpoint{EndpointKind::kTcp, "", "", 0, -1};
  if (!parse_number(rest.substr(colon + 1), endpoint.port)) refuse(text, "a port from 0 to 65535 in tcp:HOST:PORT");
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  if (host == "localhost") host = "127.0.0.1";
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(std::string(host), error);
  if (error) refuse(text, "a numeric address or \"localhost\" in tcp:HOST:PORT");
  endpoint.address = address.to_string();
  return endpoint;
}

}  // namespace

Endpoint parse_endpoint(std::string_view text) {
  if (text.starts_with("unix:")) {
    Endpoint endpoint{EndpointKind::kUnix, std::string(text.substr(5)), "", 0, -1};
    const std::size_t limit = sizeof(sockaddr_un::sun_path) - 1;
    if (endpoint.path.empty() || endpoint.path.size() > limit) {
      refuse(text, fmt::format("unix:PATH with a path of 1 to {} bytes", limit));
    }
    return endpoint;
  }
  if (text.starts_with("tcp:")) return parse_tcp(text, text.substr(4));
  if (text.starts_with("fd:")) {
    Endpoint endpoint{EndpointKind::kFd, "", "", 0, -1};
    if (!parse_number(text.substr(3), endpoint.fd) || endpoint.fd < 0)
      refuse(text, "fd:N with the number of an open socket");
    return endpoint;
  }
  refuse(text, "unix:PATH, tcp:HOST:PORT or fd:N");
}

std::string to_string(const Endpoint& endpoint) {
  if (endpoint.kind == EndpointKind::kUnix) return "unix:" + endpoint.path;
  if (endpoint.kind == EndpointKind::kFd) return fmt::format("fd:{}", endpoint.fd);
  const bool is_v6 = endpoint.address.find(':') != std::string::npos;
  const std::string host = is_v6 ? "[" + endpoint.address + "]" : endpoint.address;
  return fmt::format("{}:{}:{}", endpoint.is_secure ? "tls" : "tcp", host, endpoint.port);
}

bool is_local(const Endpoint& endpoint) {
  return endpoint.kind != EndpointKind::kTcp || boost::asio::ip::make_address(endpoint.address).is_loopback();
}

Endpoint for_board(const Endpoint& endpoint, std::uint32_t board) {
  if (board == 0) return endpoint;
  if (endpoint.kind == EndpointKind::kFd) throw std::invalid_argument("expected one board on fd:N, got several");
  Endpoint own = endpoint;
  if (endpoint.kind == EndpointKind::kUnix) return parse_endpoint(fmt::format("unix:{}.{}", endpoint.path, board));
  if (endpoint.port == 0) return own;
  if (endpoint.port + board > 65535) {
    throw std::invalid_argument(
        fmt::format("expected ports up to 65535, got {} for board {}", endpoint.port + board, board));
  }
  own.port = static_cast<std::uint16_t>(endpoint.port + board);
  return own;
}

bool is_listening(int fd) {
  const auto option = [fd](int name) {
    int value = -1;
    socklen_t size = sizeof value;
    return ::getsockopt(fd, SOL_SOCKET, name, &value, &size) == 0 ? value : -1;
  };
  return option(SO_DOMAIN) == AF_UNIX && option(SO_TYPE) == SOCK_STREAM && option(SO_ACCEPTCONN) == 1;
}

void remove_stale_socket(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return;  // not found; bind() reports other errors
  if (!S_ISSOCK(status.st_mode))
    throw std::runtime_error(
        fmt::format("unix:{}: expected a path without a file, got a file that is no socket", path));
  if (listens(path)) throw std::runtime_error(fmt::format("unix:{}: another process is listening there", path));
  ::unlink(path.c_str());
}

}  // namespace gicube::emu

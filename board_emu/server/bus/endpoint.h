// Address of a plane of the board: unix:PATH, tcp:HOST:PORT or, for an open socket, fd:N.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace gicube::emu {

enum class EndpointKind { kUnix, kTcp, kFd };

struct Endpoint {
  EndpointKind kind = EndpointKind::kUnix;
  std::string path;        // unix
  std::string address;     // tcp: a numeric IPv4 or IPv6 address without brackets
  std::uint16_t port = 0;  // tcp; 0 = any free one
  int fd = -1;             // fd
  bool is_secure = false;  // tcp: with TLS

  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

// Throws std::invalid_argument with the expected format. "localhost" means 127.0.0.1. Other host names are refused,
// because access must not depend on a name server.
Endpoint parse_endpoint(std::string_view text);

// The text that parse_endpoint() reads; with TLS tls:HOST:PORT, as drivers open it.
std::string to_string(const Endpoint& endpoint);

// True if other machines cannot reach it.
bool is_local(const Endpoint& endpoint);

// The endpoint of board i: PATH.i or PORT + i; for board 0 the endpoint itself. Port 0 stays 0. Throws
// std::invalid_argument if the port exceeds 65535 or the endpoint is a single socket.
Endpoint for_board(const Endpoint& endpoint, std::uint32_t board);

// True for a listening Unix stream socket, such as systemd passes.
bool is_listening(int fd);

// Removes a socket file without a listener. Throws std::runtime_error if there is one, or if the file is not a socket.
void remove_stale_socket(const std::string& path);

}  // namespace gicube::emu

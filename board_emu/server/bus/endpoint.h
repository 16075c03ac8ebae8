// Where a plane of the board is reached: unix:PATH, tcp:HOST:PORT or, for an open socket, fd:N.
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
  bool is_secure = false;  // tcp: by TLS

  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

// Throws std::invalid_argument that says what was expected. "localhost" means 127.0.0.1; other host names are refused,
// because who is let in must not depend on a name server.
Endpoint parse_endpoint(std::string_view text);

// The text that parse_endpoint() reads back; of one with TLS, tls:HOST:PORT, as drivers open it.
std::string to_string(const Endpoint& endpoint);

// True for everything that other machines can't reach.
bool is_local(const Endpoint& endpoint);

// Board i of a process listens at PATH.i or PORT + i; board 0 at the endpoint itself. Port 0 stays 0. Throws
// std::invalid_argument if the port passes 65535 or the endpoint is one socket.
Endpoint for_board(const Endpoint& endpoint, std::uint32_t board);

// True for a Unix stream socket that clients connect to, as systemd hands it over.
bool is_listening(int fd);

// Removes a socket file that nobody answers on. Throws std::runtime_error if someone does, or if it is no socket.
void remove_stale_socket(const std::string& path);

}  // namespace gicube::emu

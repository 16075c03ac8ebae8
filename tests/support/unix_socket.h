// Unix sockets without a server.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <stdexcept>
#include <string>

namespace gicube::reference {

inline sockaddr_un unix_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  return address;
}

// A socket at `path`, which listens unless `backlog` is 0. Throws std::runtime_error.
inline int bound_socket(const std::string& path, int backlog = 8, int flags = SOCK_CLOEXEC) {
  const sockaddr_un address = unix_address(path);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | flags, 0);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      (backlog != 0 && ::listen(fd, backlog) != 0)) {
    throw std::runtime_error("no socket at " + path);
  }
  return fd;
}

}  // namespace gicube::reference

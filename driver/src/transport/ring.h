// Bytes between a ring in shared memory (gicube/wire/pci_function.h) and a socket, as many as go without waiting.
#pragma once

#include <sys/socket.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gicube/wire/pci_function.h"

namespace gicube {

enum class RingStop { kAllMoved, kMustWait, kClosed };

// Moves `count` bytes from `index` on, which it advances, by `io(data, size)`: as ::send() and ::recv().
template <typename Io>
RingStop move_bytes(std::span<std::byte> ring, std::uint32_t& index, std::uint32_t count, const Io& io) {
  while (count > 0) {
    const auto piece = wire::function::piece_of(ring, index, count);
    const ssize_t moved = io(piece.data(), piece.size());
    if (moved < 0 && errno == EINTR) continue;
    if (moved <= 0) return moved < 0 && errno == EAGAIN ? RingStop::kMustWait : RingStop::kClosed;
    index += static_cast<std::uint32_t>(moved);
    count -= static_cast<std::uint32_t>(moved);
  }
  return RingStop::kAllMoved;
}

inline RingStop ring_to_socket(std::span<std::byte> ring, std::uint32_t& index, std::uint32_t count, int socket) {
  return move_bytes(ring, index, count, [socket](const void* data, std::size_t size) {
    return ::send(socket, data, size, MSG_DONTWAIT | MSG_NOSIGNAL);
  });
}
inline RingStop socket_to_ring(int socket, std::span<std::byte> ring, std::uint32_t& index, std::uint32_t count) {
  return move_bytes(ring, index, count,
                    [socket](void* data, std::size_t size) { return ::recv(socket, data, size, MSG_DONTWAIT); });
}

}  // namespace gicube

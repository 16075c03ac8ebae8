// Shared memory, and bytes between a ring in it (gicube/wire/pci_function.h) and a socket: as many as can be moved at
// once.
#pragma once

#include <sys/mman.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "gicube/wire/pci_function.h"

namespace gicube {

// Mapped memory, which can be read, written and shared with others, as long as its owner lives.
struct Unmap {
  std::size_t bytes = 0;
  void operator()(std::byte* at) const { ::munmap(at, bytes); }
};
using Mapping = std::unique_ptr<std::byte, Unmap>;

// Empty if it can't be mapped: errno says why.
inline Mapping map_shared(std::size_t bytes, int file, off_t offset = 0, int flags = 0) {
  void* const at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | flags, file, offset);
  return {at == MAP_FAILED ? nullptr : static_cast<std::byte*>(at), {bytes}};
}

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

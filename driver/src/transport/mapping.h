// Memory that is mapped, to be read, written and shared with others, as long as its owner lives.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <memory>

namespace gicube {

struct Unmap {
  std::size_t bytes = 0;
  void operator()(std::byte* at) const { ::munmap(at, bytes); }
};
using Mapping = std::unique_ptr<std::byte, Unmap>;

// Empty if it can't be: errno says why.
inline Mapping map_shared(std::size_t bytes, int file, off_t offset = 0, int flags = 0) {
  void* const at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | flags, file, offset);
  return {at == MAP_FAILED ? nullptr : static_cast<std::byte*>(at), {bytes}};
}

}  // namespace gicube

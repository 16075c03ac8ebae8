// The guest's memory, as QEMU shares it: pieces of files, each at an address of the guest.
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "transport/fd.h"
#include "transport/ring.h"

namespace gicube::pci {

struct MemoryRegion {
  std::uint64_t address = 0;  // of the guest
  std::uint64_t bytes = 0;
  std::uint64_t offset = 0;  // in its file
  Fd file;
};

class GuestMemory {
 public:
  // Replaces all regions. A region that can't be mapped, or exceeds its file, is left out: accesses beyond a file's end
  // raise SIGBUS.
  void map(std::span<const MemoryRegion> regions) {
    mapped_.clear();
    for (const auto& [address, bytes, offset, file] : regions) {
      struct stat info {};
      const bool known = ::fstat(file.get(), &info) == 0 && info.st_size > 0;
      const std::uint64_t size = known ? static_cast<std::uint64_t>(info.st_size) : 0;
      if (bytes == 0 || offset > size || bytes > size - offset) continue;
      Mapping mapped = map_shared(bytes, file.get(), static_cast<off_t>(offset));
      if (mapped) mapped_.emplace_back(address, std::move(mapped));
    }
  }

  // The bytes at an address of the guest; empty unless all are within one region. They are valid until the next map().
  std::span<std::byte> find(std::uint64_t address, std::uint64_t bytes) const {
    for (const auto& [base, mapped] : mapped_) {
      const std::uint64_t size = mapped.get_deleter().bytes, at = address - base;
      if (address >= base && at <= size && bytes <= size - at) return {mapped.get() + at, bytes};
    }
    return {};
  }

 private:
  std::vector<std::pair<std::uint64_t, Mapping>> mapped_;  // addresses of the guest
};

}  // namespace gicube::pci

// The guest's memory, as QEMU shares it: pieces of files, each at an address of the guest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "transport/fd.h"
#include "transport/mapping.h"

namespace gicube::pci {

struct MemoryRegion {
  std::uint64_t address = 0;  // of the guest
  std::uint64_t bytes = 0;
  std::uint64_t offset = 0;  // in its file
  Fd file;
};

class GuestMemory {
 public:
  // These regions in place of the former. What can't be mapped, or is not within its file, is left out.
  void map(std::span<const MemoryRegion> regions);

  // The bytes at an address of the guest; empty unless all are within one region. They are valid until the next map().
  std::span<std::byte> find(std::uint64_t address, std::uint64_t bytes) const;

 private:
  struct Mapped {
    std::uint64_t address;
    Mapping bytes;
  };
  std::vector<Mapped> mapped_;
};

}  // namespace gicube::pci

#include "guest_memory.h"

#include <sys/stat.h>

#include <utility>

namespace gicube::pci {

void GuestMemory::map(std::span<const MemoryRegion> regions) {
  mapped_.clear();
  for (const auto& [address, bytes, offset, file] : regions) {
    struct stat info {};
    // A page of a mapping that is not in its file would be a SIGBUS.
    if (::fstat(file.get(), &info) != 0 || info.st_size <= 0) continue;
    const auto size = static_cast<std::uint64_t>(info.st_size);
    if (bytes == 0 || offset > size || bytes > size - offset) continue;
    Mapping mapped = map_shared(bytes, file.get(), static_cast<off_t>(offset));
    if (mapped) mapped_.push_back({address, std::move(mapped)});
  }
}

std::span<std::byte> GuestMemory::find(std::uint64_t address, std::uint64_t bytes) const {
  for (const auto& [base, mapped] : mapped_) {
    const std::uint64_t size = mapped.get_deleter().bytes, at = address - base;
    if (address >= base && at <= size && bytes <= size - at) return {mapped.get() + at, bytes};
  }
  return {};
}

}  // namespace gicube::pci

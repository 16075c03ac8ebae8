#include "guest_memory.h"

#include <sys/mman.h>
#include <sys/stat.h>

namespace gicube::pci {

void GuestMemory::map(std::span<const MemoryRegion> regions) {
  clear();
  for (const MemoryRegion& region : regions) {
    struct stat file {};
    if (::fstat(region.file.get(), &file) != 0 || file.st_size <= 0) continue;
    const auto size = static_cast<std::uint64_t>(file.st_size);
    // A page of a mapping that is not in its file would be a SIGBUS.
    if (region.bytes == 0 || region.offset > size || region.bytes > size - region.offset) continue;
    void* const at = ::mmap(nullptr, region.bytes, PROT_READ | PROT_WRITE, MAP_SHARED, region.file.get(),
                            static_cast<off_t>(region.offset));
    if (at == MAP_FAILED) continue;
    mapped_.push_back({region.address, {static_cast<std::byte*>(at), region.bytes}});
  }
}

std::span<std::byte> GuestMemory::find(std::uint64_t address, std::uint64_t bytes) const {
  for (const auto& [base, mapped] : mapped_) {
    if (address < base || address - base > mapped.size() || bytes > mapped.size() - (address - base)) continue;
    return mapped.subspan(address - base, bytes);
  }
  return {};
}

void GuestMemory::clear() {
  for (const Mapped& each : mapped_) ::munmap(each.bytes.data(), each.bytes.size());
  mapped_.clear();
}

}  // namespace gicube::pci

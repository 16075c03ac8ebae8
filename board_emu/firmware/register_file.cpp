#include "firmware/register_file.h"

#include "gicube/wire/memory_map.h"

namespace gicube::emu {

void RegisterFile::reset() {
  for (const wire::RegisterInfo& info : wire::kRegisterTable) {
    const bool fixed = info.access == wire::Access::kReadOnly && info.offset != wire::reg::kStatus &&
                       info.offset != wire::reg::kErrorAddress && info.offset != wire::reg::kId;
    if (!fixed) words_[info.offset / 4] = info.reset;
  }
}

std::uint32_t RegisterFile::read(std::uint32_t offset) const {
  const wire::RegisterInfo* info = wire::find_register(offset);
  if (info == nullptr || info->access == wire::Access::kWriteOnly) return wire::kUnmappedRead;
  return words_[offset / 4];
}

bool RegisterFile::write(std::uint32_t offset, std::uint32_t value) {
  if (offset == wire::reg::kStatusClear) {
    words_[wire::reg::kStatus / 4] &= ~value;
    return true;
  }
  const wire::RegisterInfo* info = wire::find_register(offset);
  if (info == nullptr || info->access == wire::Access::kReadOnly) {
    raise(wire::kStatusBadAddress, offset);
    return false;
  }
  if (info->access == wire::Access::kReadWrite) words_[offset / 4] = value;
  return true;
}

void RegisterFile::raise(wire::StatusBit bit, std::uint32_t address) {
  words_[wire::reg::kStatus / 4] |= bit;
  words_[wire::reg::kErrorAddress / 4] = address;
}

std::uint32_t PciConfigFile::read(std::uint32_t offset) const {
  if (offset % 4 != 0 || offset >= wire::kPciConfigBytes) return wire::kUnmappedRead;
  return space_[offset / 4];
}

void PciConfigFile::write(std::uint32_t offset, std::uint32_t value) {
  namespace pci = wire::pci;
  // BAR2 covers the memory map, rounded up to a power of two.
  constexpr std::uint64_t kBar2Bytes = std::uint64_t{1} << 34;
  static_assert(wire::kVolume.base + wire::kVolume.bytes <= kBar2Bytes);
  switch (offset) {
    case pci::kCommandStatus: space_[offset / 4] = (space_[offset / 4] & 0xFFFF'0000u) | (value & 0x0007u); break;
    case pci::kBar0Register: space_[offset / 4] = value & ~(wire::kBar0Bytes - 1); break;
    case pci::kBar2Low: space_[offset / 4] = (value & static_cast<std::uint32_t>(~(kBar2Bytes - 1))) | 0xC; break;
    case pci::kBar2High: space_[offset / 4] = value & static_cast<std::uint32_t>(~(kBar2Bytes - 1) >> 32); break;
    case pci::kInterrupt: space_[offset / 4] = (space_[offset / 4] & ~0xFFu) | (value & 0xFFu); break;
    default: break;
  }
}

}  // namespace gicube::emu

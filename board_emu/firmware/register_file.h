// Storage of BAR0 and the PCI configuration space, with the access rules of the shared register table and sticky status
// bits.
//
// It does not interpret values; the board does.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "gicube/archive.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/pci_config.h"
#include "gicube/wire/registers.h"

namespace gicube::emu {

class RegisterFile {
 public:
  RegisterFile() { reset(); }

  // Resets the read-write registers and STATUS. Values of set_fixed() stay.
  void reset() {
    for (const wire::RegisterInfo& info : wire::kRegisterTable) {
      if (!is_fixed(info)) words_[info.offset / 4] = info.reset;
    }
  }

  // Sets a read-only register whose value comes from the configuration.
  void set_fixed(std::uint32_t offset, std::uint32_t value) { words_[offset / 4] = value; }

  // Read by the host: all ones if there is no readable register.
  std::uint32_t read(std::uint32_t offset) const {
    const wire::RegisterInfo* info = wire::find_register(offset);
    if (info == nullptr || info->access == wire::Access::kWriteOnly) return wire::kUnmappedRead;
    return words_[offset / 4];
  }
  // Write by the host to a read-write register. Others set bad_address and return false, except STATUS_CLEAR.
  bool write(std::uint32_t offset, std::uint32_t value) {
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

  std::uint32_t value(std::uint32_t offset) const { return words_[offset / 4]; }
  void raise(wire::StatusBit bit, std::uint32_t address) {
    words_[wire::reg::kStatus / 4] |= bit;
    words_[wire::reg::kErrorAddress / 4] = address;
  }
  // Does not include registers whose values come from the configuration.
  void state(Archive& archive) {
    for (const wire::RegisterInfo& info : wire::kRegisterTable) {
      const bool is_last_refusal = info.offset == wire::reg::kMemoryAsked;
      if (!is_fixed(info) || is_last_refusal) archive(info.name, words_[info.offset / 4]);
    }
  }

 private:
  static bool is_fixed(const wire::RegisterInfo& info) {
    return info.access == wire::Access::kReadOnly && info.offset != wire::reg::kStatus &&
           info.offset != wire::reg::kErrorAddress && info.offset != wire::reg::kId;
  }

  std::array<std::uint32_t, wire::kBar0Bytes / 4> words_{};
};

// Reads beyond the 256 bytes or not at a dword return all ones. Writes affect COMMAND, the BARs (their size bits are
// fixed, so that writing ones determines the size) and the interrupt line.
class PciConfigFile {
 public:
  explicit PciConfigFile(std::uint32_t agp_rates) : space_(wire::pci_config_at_reset(agp_rates)) {}

  std::uint32_t read(std::uint32_t offset) const {
    if (offset % 4 != 0 || offset >= wire::kPciConfigBytes) return wire::kUnmappedRead;
    return space_[offset / 4];
  }
  void write(std::uint32_t offset, std::uint32_t value) {
    namespace pci = wire::pci;
    // BAR2 covers the memory map, rounded up to a power of two.
    constexpr std::uint64_t kBar2Bytes = std::uint64_t{1} << 36;
    static_assert(wire::kBlueIrradiance.base + wire::kBlueIrradiance.bytes <= kBar2Bytes);
    switch (offset) {
      case pci::kCommandStatus: space_[offset / 4] = (space_[offset / 4] & 0xFFFF'0000u) | (value & 0x0007u); break;
      case pci::kBar0Register: space_[offset / 4] = value & ~(wire::kBar0Bytes - 1); break;
      case pci::kBar2Low: space_[offset / 4] = (value & static_cast<std::uint32_t>(~(kBar2Bytes - 1))) | 0xC; break;
      case pci::kBar2High: space_[offset / 4] = value & static_cast<std::uint32_t>(~(kBar2Bytes - 1) >> 32); break;
      case pci::kInterrupt: space_[offset / 4] = (space_[offset / 4] & ~0xFFu) | (value & 0xFFu); break;
      default: break;
    }
  }
  // The registers that write() can change.
  void state(Archive& archive) {
    namespace pci = wire::pci;
    for (const auto offset :
         {pci::kCommandStatus, pci::kBar0Register, pci::kBar2Low, pci::kBar2High, pci::kInterrupt}) {
      std::uint32_t value = space_[offset / 4];
      archive("register" + std::to_string(offset), value);
      if (archive.loads()) write(offset, value);
    }
  }

 private:
  wire::PciConfigSpace space_;
};

}  // namespace gicube::emu

// The configuration space of the function in the guest: the board's ids and class (pci_config.h), and the properties of
// this function.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "gicube/wire/pci_config.h"

namespace gicube::pci {

// Capabilities: power management, whose way from D3hot to D0 is a reset, and Advanced Features with function-level
// reset (PCI ECN "Advanced Capabilities for Conventional PCI", 2006). BAR 0 has the registers. There is no BAR 2: QEMU
// gives at most 1 GiB, and the board's memory map ends at 34 GiB. There is no AGP capability, because the function is
// on the guest's PCI bus.
class ConfigSpace {
 public:
  ConfigSpace() { reset(); }
  void reset() {
    const wire::PciConfigSpace words = wire::pci_config_at_reset(0);
    for (std::uint32_t i = 0; i < bytes_.size(); ++i) bytes_[i] = static_cast<std::uint8_t>(words[i / 4] >> i % 4 * 8);
    // The guest's firmware assigns its address, and enables it.
    std::fill_n(bytes_.begin() + kCommand, 2, std::uint8_t{0});
    std::fill(bytes_.begin() + wire::pci::kBar0Register, bytes_.begin() + wire::pci::kBar2High + 4, std::uint8_t{0});
    bytes_[kPower + 1] = kAdvancedFeatures;
    // Its id, the last of the list, 6 bytes, with transactions pending and function-level reset.
    std::ranges::copy(std::array<std::uint8_t, 4>{0x13, 0, 6, 3}, bytes_.begin() + kAdvancedFeatures);
  }

  // `size` bytes from `offset` on; beyond the 256 bytes all bits are 1.
  std::uint32_t read(std::uint64_t offset, std::uint64_t size) const {
    std::uint32_t value = 0;
    for (std::uint32_t i = 0; i < std::min<std::uint64_t>(size, 4); ++i) {
      value |= (offset + i < bytes_.size() ? std::uint32_t{bytes_[offset + i]} : 0xFFu) << 8 * i;
    }
    return value;
  }
  // True: the guest has requested a reset of the function; this space has been reset.
  bool write(std::uint64_t offset, std::uint64_t size, std::uint64_t value) {
    const unsigned power_before = power_state();
    bool resets = false;
    for (std::uint64_t at = offset; at < offset + std::min<std::uint64_t>(size, 4) && at < bytes_.size(); ++at) {
      const auto byte = static_cast<std::uint8_t>(value >> 8 * (at - offset));
      bytes_[at] = static_cast<std::uint8_t>((bytes_[at] & ~kWritable[at]) | (byte & kWritable[at]));
      resets = resets || (at == kAdvancedFeatures + 4 && (byte & 1) != 0);
    }
    resets = resets || (power_before == 3 && power_state() == 0);
    if (resets) reset();
    return resets;
  }

  bool may_master_bus() const { return (bytes_[kCommand] & wire::pci::kCommandBusMaster) != 0 && power_state() == 0; }
  bool interrupts_are_disabled() const { return (bytes_[kCommand + 1] & kInterruptDisable) != 0 || power_state() != 0; }
  void show_interrupt(bool pending) {
    bytes_[kCommand + 2] = static_cast<std::uint8_t>((bytes_[kCommand + 2] & ~(1u << 3)) | (pending ? 1u << 3 : 0u));
  }

 private:
  static constexpr std::uint32_t kCommand = wire::pci::kCommandStatus, kPower = wire::pci::kPowerManagement;
  static constexpr std::uint8_t kAdvancedFeatures = 0x48;  // after power management
  static constexpr std::uint8_t kInterruptDisable = 1u << 2;
  // The bits that a guest may set, by byte.
  static constexpr auto kWritable = [] {
    static_assert(wire::kBar0Bytes == 0x1000, "byte 0x11 has the lowest writable bits of BAR 0");
    std::array<std::uint8_t, wire::kPciConfigBytes> bits{};
    bits[kCommand] = wire::pci::kCommandMemorySpace | wire::pci::kCommandBusMaster;
    bits[kCommand + 1] = kInterruptDisable;
    bits[0x0C] = bits[0x0D] = 0xFF;  // cache line size, latency timer
    bits[0x11] = 0xF0;               // BAR 0
    bits[0x12] = bits[0x13] = 0xFF;  // BAR 0
    bits[0x3C] = 0xFF;               // interrupt line
    bits[kPower + 4] = 3;            // power state
    return bits;
  }();
  unsigned power_state() const { return bytes_[kPower + 4] & 3u; }

  std::array<std::uint8_t, wire::kPciConfigBytes> bytes_{};
};

}  // namespace gicube::pci

// The configuration space of the function in the guest: the board's ids and class (pci_config.h), with what is true of
// this function.
#pragma once

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
  void reset();

  // `size` bytes from `offset` on; all ones beyond the 256 bytes.
  std::uint32_t read(std::uint64_t offset, std::uint64_t size) const;
  // True: the guest wants the function to be reset; this space has been.
  bool write(std::uint64_t offset, std::uint64_t size, std::uint64_t value);

  bool may_master_bus() const { return (bytes_[kCommand] & wire::pci::kCommandBusMaster) != 0 && power_state() == 0; }
  bool interrupts_are_disabled() const { return (bytes_[kCommand + 1] & 1u << 2) != 0 || power_state() != 0; }
  void show_interrupt(bool pending);

 private:
  static constexpr std::uint32_t kCommand = wire::pci::kCommandStatus;
  unsigned power_state() const { return bytes_[wire::pci::kPowerManagement + 4] & 3u; }

  std::array<std::uint8_t, wire::kPciConfigBytes> bytes_{};
};

}  // namespace gicube::pci

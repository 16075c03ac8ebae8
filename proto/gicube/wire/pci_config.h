// The board's PCI configuration header (type 0, PCI Local Bus Specification 2.2): ids, class, BARs, capability list.
#pragma once

#include <array>
#include <cstdint>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

inline constexpr std::size_t kPciConfigBytes = 256;
inline constexpr std::uint16_t kVendorId = 0x4749;      // chosen: "GI"; not an assigned PCI-SIG number
inline constexpr std::uint16_t kDeviceId = 0x0C5B;      // chosen
inline constexpr std::uint32_t kClassCode = 0x0B4000;   // co-processor
inline constexpr std::uint32_t kBar0 = 0xE000'0000;     // chosen: an address that a BIOS might assign
inline constexpr std::uint32_t kBar0Bytes = 0x1000;     // registers
inline constexpr std::uint64_t kBar2 = 0x40'0000'0000;  // 64-bit prefetchable memory (memory_map.h)

namespace pci {
inline constexpr std::uint32_t kIds = 0x00;
inline constexpr std::uint32_t kCommandStatus = 0x04;
inline constexpr std::uint32_t kClassRevision = 0x08;
inline constexpr std::uint32_t kBar0Register = 0x10;
inline constexpr std::uint32_t kBar2Low = 0x18;
inline constexpr std::uint32_t kBar2High = 0x1C;
inline constexpr std::uint32_t kSubsystem = 0x2C;
inline constexpr std::uint32_t kCapabilities = 0x34;
inline constexpr std::uint32_t kInterrupt = 0x3C;
inline constexpr std::uint32_t kPowerManagement = 0x40;
inline constexpr std::uint32_t kAgp = 0x50;
inline constexpr std::uint32_t kCommandMemorySpace = 1u << 1;
inline constexpr std::uint32_t kCommandBusMaster = 1u << 2;
inline constexpr std::uint8_t kCapabilityPowerManagement = 0x01;
inline constexpr std::uint8_t kCapabilityAgp = 0x02;
}  // namespace pci

using PciConfigSpace = std::array<std::uint32_t, kPciConfigBytes / 4>;

// The header after power-up. `agp_rates`: 0 for a PCI card; for AGP the bits of the supported rates: 1x = 1, 2x = 2, 4x
// = 4.
constexpr PciConfigSpace pci_config_at_reset(std::uint32_t agp_rates) {
  PciConfigSpace space{};
  space[pci::kIds / 4] = std::uint32_t{kDeviceId} << 16 | kVendorId;
  space[pci::kCommandStatus / 4] = 1u << 20 | pci::kCommandMemorySpace | pci::kCommandBusMaster;  // capability list
  space[pci::kClassRevision / 4] = kClassCode << 8 | 0x01;
  space[pci::kBar0Register / 4] = kBar0;                               // 32-bit, not prefetchable
  space[pci::kBar2Low / 4] = static_cast<std::uint32_t>(kBar2) | 0xC;  // 64-bit, prefetchable
  space[pci::kBar2High / 4] = static_cast<std::uint32_t>(kBar2 >> 32);
  space[pci::kSubsystem / 4] = std::uint32_t{kDeviceId} << 16 | kVendorId;
  space[pci::kCapabilities / 4] = pci::kPowerManagement;
  space[pci::kInterrupt / 4] = 0x0100;  // INTA#
  const std::uint32_t next = agp_rates != 0 ? pci::kAgp : 0;
  space[pci::kPowerManagement / 4] = 0x0002u << 16 | next << 8 | pci::kCapabilityPowerManagement;
  if (agp_rates != 0) {
    space[pci::kAgp / 4] = 0x0020u << 16 | pci::kCapabilityAgp;    // AGP 2.0, last in the list
    space[pci::kAgp / 4 + 1] = 0x1Fu << 24 | 1u << 9 | agp_rates;  // 32 requests, sideband addressing
  }
  return space;
}

}  // namespace gicube::wire

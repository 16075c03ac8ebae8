#include "config_space.h"

#include <algorithm>

namespace gicube::pci {
namespace {

constexpr std::uint32_t kAdvancedFeatures = 0x48;  // behind power management
constexpr std::uint32_t kAdvancedControl = kAdvancedFeatures + 4;
constexpr std::uint8_t kCapabilityAdvancedFeatures = 0x13;
constexpr std::uint8_t kTransactionsPending = 1, kFunctionLevelReset = 2;  // that there are these two bits

// The bits that a guest may set, by byte: memory space, bus master and INTx disable; cache line size; latency timer; BAR 0; interrupt line;
// power state.
std::uint8_t writable(std::uint32_t offset) {
  switch (offset) {
    case 0x04: return wire::pci::kCommandMemorySpace | wire::pci::kCommandBusMaster;
    case 0x05: return 1u << 2;
    case 0x0C:
    case 0x0D:
    case 0x3C: return 0xFF;
    case 0x11: return 0xF0;
    case 0x12:
    case 0x13: return 0xFF;
    case wire::pci::kPowerManagement + 4: return 3;
    default: return 0;
  }
}
static_assert(wire::kBar0Bytes == 0x1000, "byte 0x11 has the lowest writable bits of BAR 0");

}  // namespace

void ConfigSpace::reset() {
  const wire::PciConfigSpace words = wire::pci_config_at_reset(0);
  for (std::uint32_t i = 0; i < bytes_.size(); ++i) {
    bytes_[i] = static_cast<std::uint8_t>(words[i / 4] >> i % 4 * 8);
  }
  // The guest's firmware gives it an address, and enables it.
  for (std::uint32_t at = kCommand; at < kCommand + 2; ++at) bytes_[at] = 0;
  for (std::uint32_t at = wire::pci::kBar0Register; at < wire::pci::kBar2High + 4; ++at) bytes_[at] = 0;
  bytes_[wire::pci::kPowerManagement + 1] = kAdvancedFeatures;
  bytes_[kAdvancedFeatures] = kCapabilityAdvancedFeatures;
  bytes_[kAdvancedFeatures + 2] = 6;  // its bytes
  bytes_[kAdvancedFeatures + 3] = kTransactionsPending | kFunctionLevelReset;
}

std::uint32_t ConfigSpace::read(std::uint32_t offset, std::uint32_t size) const {
  std::uint32_t value = 0;
  for (std::uint32_t i = 0; i < std::min(size, 4u); ++i) {
    const std::uint64_t at = std::uint64_t{offset} + i;
    value |= (at < bytes_.size() ? std::uint32_t{bytes_[at]} : 0xFFu) << 8 * i;
  }
  return value;
}

bool ConfigSpace::write(std::uint32_t offset, std::uint32_t size, std::uint32_t value) {
  const unsigned power_before = power_state();
  bool resets = false;
  for (std::uint32_t i = 0; i < std::min(size, 4u); ++i) {
    const std::uint64_t at = std::uint64_t{offset} + i;
    if (at >= bytes_.size()) break;
    const auto byte = static_cast<std::uint8_t>(value >> 8 * i);
    const std::uint8_t mask = writable(static_cast<std::uint32_t>(at));
    bytes_[at] = static_cast<std::uint8_t>((bytes_[at] & ~mask) | (byte & mask));
    resets = resets || (at == kAdvancedControl && (byte & 1) != 0);
  }
  resets = resets || (power_before == 3 && power_state() == 0);
  if (resets) reset();
  return resets;
}

void ConfigSpace::show_interrupt(bool pending) {
  constexpr std::uint8_t kInterruptStatus = 1u << 3;
  std::uint8_t& status = bytes_[kCommand + 2];
  status = static_cast<std::uint8_t>(pending ? status | kInterruptStatus : status & ~kInterruptStatus);
}

}  // namespace gicube::pci

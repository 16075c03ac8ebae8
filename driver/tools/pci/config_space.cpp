#include "config_space.h"

#include <algorithm>

namespace gicube::pci {
namespace {

constexpr std::uint32_t kAdvancedFeatures = 0x48;  // behind power management
constexpr std::uint32_t kAdvancedControl = kAdvancedFeatures + 4;

// The bits that a guest may set, by byte.
constexpr auto kWritable = [] {
  static_assert(wire::kBar0Bytes == 0x1000, "byte 0x11 has the lowest writable bits of BAR 0");
  std::array<std::uint8_t, wire::kPciConfigBytes> bits{};
  bits[0x04] = wire::pci::kCommandMemorySpace | wire::pci::kCommandBusMaster;
  bits[0x05] = 1u << 2;                       // INTx disable
  bits[0x0C] = bits[0x0D] = 0xFF;             // cache line size, latency timer
  bits[0x11] = 0xF0;                          // BAR 0
  bits[0x12] = bits[0x13] = 0xFF;             // BAR 0
  bits[0x3C] = 0xFF;                          // interrupt line
  bits[wire::pci::kPowerManagement + 4] = 3;  // power state
  return bits;
}();

}  // namespace

void ConfigSpace::reset() {
  const wire::PciConfigSpace words = wire::pci_config_at_reset(0);
  for (std::uint32_t i = 0; i < bytes_.size(); ++i) {
    bytes_[i] = static_cast<std::uint8_t>(words[i / 4] >> i % 4 * 8);
  }
  // The guest's firmware gives it an address, and enables it.
  std::fill_n(bytes_.begin() + kCommand, 2, std::uint8_t{0});
  std::fill(bytes_.begin() + wire::pci::kBar0Register, bytes_.begin() + wire::pci::kBar2High + 4, std::uint8_t{0});
  bytes_[wire::pci::kPowerManagement + 1] = kAdvancedFeatures;
  // Its id, the last of the list, 6 bytes, with transactions pending and function-level reset.
  std::ranges::copy(std::array<std::uint8_t, 4>{0x13, 0, 6, 3}, bytes_.begin() + kAdvancedFeatures);
}

std::uint32_t ConfigSpace::read(std::uint64_t offset, std::uint64_t size) const {
  std::uint32_t value = 0;
  for (std::uint32_t i = 0; i < std::min<std::uint64_t>(size, 4); ++i) {
    value |= (offset + i < bytes_.size() ? std::uint32_t{bytes_[offset + i]} : 0xFFu) << 8 * i;
  }
  return value;
}

bool ConfigSpace::write(std::uint64_t offset, std::uint64_t size, std::uint64_t value) {
  const unsigned power_before = power_state();
  bool resets = false;
  for (std::uint64_t at = offset; at < offset + std::min<std::uint64_t>(size, 4) && at < bytes_.size(); ++at) {
    const auto byte = static_cast<std::uint8_t>(value >> 8 * (at - offset));
    bytes_[at] = static_cast<std::uint8_t>((bytes_[at] & ~kWritable[at]) | (byte & kWritable[at]));
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

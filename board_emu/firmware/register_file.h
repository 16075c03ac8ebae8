// BAR0 and the PCI configuration space as storage: access rules of the shared register table, sticky status bits.
//
// What a register's value means is the board's business; this only keeps words and refuses what the table forbids.
#pragma once

#include <array>
#include <cstdint>

#include "gicube/wire/pci_config.h"
#include "gicube/wire/registers.h"

namespace gicube::emu {

class RegisterFile {
 public:
  RegisterFile() { reset(); }

  // Read-write registers and STATUS back to their reset values; what set_fixed() set stays.
  void reset();

  // A read-only register whose value comes from the configuration.
  void set_fixed(std::uint32_t offset, std::uint32_t value) { words_[offset / 4] = value; }

  // The host's read: all ones where no readable register is.
  std::uint32_t read(std::uint32_t offset) const;
  // The host's write of a read-write register; anything else sets bad_address and returns false. STATUS_CLEAR works.
  bool write(std::uint32_t offset, std::uint32_t value);

  std::uint32_t value(std::uint32_t offset) const { return words_[offset / 4]; }
  void raise(wire::StatusBit bit, std::uint32_t address);

 private:
  std::array<std::uint32_t, wire::kBar0Bytes / 4> words_{};
};

// Reads give all ones beyond the 256 bytes or off a dword. Writes reach COMMAND, the BARs (whose size bits are fixed, so
// that writing ones sizes them) and the interrupt line.
class PciConfigFile {
 public:
  explicit PciConfigFile(std::uint32_t agp_rates) : space_(wire::pci_config_at_reset(agp_rates)) {}

  std::uint32_t read(std::uint32_t offset) const;
  void write(std::uint32_t offset, std::uint32_t value);

 private:
  wire::PciConfigSpace space_;
};

}  // namespace gicube::emu

// Where a packet lies in a channel's memory.
#pragma once

#include <cstdint>

namespace gicube::emu::rdram {

struct Location {
  std::uint16_t device = 0;
  std::uint16_t row = 0;
  std::uint8_t bank = 0;
  std::uint8_t column = 0;  // dualoct within the row

  friend constexpr bool operator==(const Location&, const Location&) = default;
};

}  // namespace gicube::emu::rdram

// Simulated time in whole picoseconds, and cycles of clocks given in kHz.
#pragma once

#include <cstdint>

namespace gicube::emu {

using Picoseconds = std::uint64_t;

using Cycle = std::uint64_t;  // of the ASIC's core clock

inline constexpr Cycle kNoCycle = ~Cycle{0};
inline constexpr Picoseconds kNever = ~Picoseconds{0};

// `cycles` of a clock of `khz`, to the picosecond below; exact for every clock whose period is a whole number of them.
constexpr Picoseconds cycles_to_ps(std::uint64_t cycles, std::uint64_t khz) {
  constexpr std::uint64_t kPicosecondsPerKhz = 1'000'000'000;  // of a 1 kHz period
  // Whole milliseconds first, so that the product stays within 64 bits.
  return cycles / khz * kPicosecondsPerKhz + cycles % khz * kPicosecondsPerKhz / khz;
}

}  // namespace gicube::emu

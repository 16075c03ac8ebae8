// Simulated time in whole picoseconds, and cycles of clocks given in kHz.
#pragma once

#include <bit>
#include <cstdint>
#include <numeric>

namespace gicube::emu {

using Picoseconds = std::uint64_t;

using Cycle = std::uint64_t;  // of the ASIC's core clock

// What a checkpoint may have. Chosen: half a day of a core of 100 MHz, so low that its product with any clock's kHz fits; and, how far
// the end of what a part does may be ahead, twice the longest scattering routine.
inline constexpr Cycle kMostCycles = Cycle{1} << 42, kMostAhead = Cycle{1} << 33;

inline constexpr Cycle kNoCycle = ~Cycle{0};
inline constexpr Picoseconds kNever = ~Picoseconds{0};

// Cycles of one clock in those of another that began with it.
class ClockRatio {
 public:
  ClockRatio(std::uint64_t from_khz, std::uint64_t to_khz)
      : to_(to_khz / std::gcd(from_khz, to_khz)),
        from_(from_khz / std::gcd(from_khz, to_khz)),
        shift_(std::has_single_bit(from_) ? std::countr_zero(from_) : -1) {}

  // The first cycle that begins no earlier; of a span, the cycles in which it has passed.
  std::uint64_t from(std::uint64_t cycle) const { return divided(cycle * to_ + from_ - 1); }
  // Whole cycles that have passed.
  std::uint64_t passed(std::uint64_t cycles) const { return divided(cycles * to_); }

 private:
  std::uint64_t divided(std::uint64_t cycles) const { return shift_ >= 0 ? cycles >> shift_ : cycles / from_; }

  std::uint64_t to_, from_;
  int shift_;  // from_ is this power of two; -1: of none
};

// `cycles` of a clock of `khz`, to the picosecond below; exact for every clock whose period is a whole number of them.
constexpr Picoseconds cycles_to_ps(std::uint64_t cycles, std::uint64_t khz) {
  constexpr std::uint64_t kPicosecondsPerKhz = 1'000'000'000;  // of a 1 kHz period
  // Whole milliseconds first, so that the product stays within 64 bits.
  return cycles / khz * kPicosecondsPerKhz + cycles % khz * kPicosecondsPerKhz / khz;
}

}  // namespace gicube::emu

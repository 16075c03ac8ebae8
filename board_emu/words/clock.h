// Simulated time in whole picoseconds, and cycles of clocks given in kHz.
#pragma once

#include <bit>
#include <cstdint>
#include <numeric>

namespace gicube::emu {

using Picoseconds = std::uint64_t;

using Cycle = std::uint64_t;  // cycles of the ASIC's core clock

// Limits for a checkpoint. Chosen: kMostCycles is half a day at 100 MHz, small enough that its product with any clock's
// kHz fits into 64 bits. kMostAhead, twice the longest scattering routine, limits how far ahead the end of a part's
// work may be.
inline constexpr Cycle kMostCycles = Cycle{1} << 42, kMostAhead = Cycle{1} << 33;

inline constexpr Cycle kNoCycle = ~Cycle{0};
inline constexpr Picoseconds kNever = ~Picoseconds{0};

// Converts cycles of one clock to cycles of another that started at the same time.
class ClockRatio {
 public:
  ClockRatio(std::uint64_t from_khz, std::uint64_t to_khz)
      : to_(to_khz / std::gcd(from_khz, to_khz)),
        from_(from_khz / std::gcd(from_khz, to_khz)),
        shift_(std::has_single_bit(from_) ? std::countr_zero(from_) : -1) {}

  // The first cycle that begins no earlier than `cycle`; the length of a time span, rounded up.
  std::uint64_t from(std::uint64_t cycle) const { return divided(cycle * to_ + from_ - 1); }
  // The length of a time span, rounded down.
  std::uint64_t passed(std::uint64_t cycles) const { return divided(cycles * to_); }

 private:
  std::uint64_t divided(std::uint64_t cycles) const { return shift_ >= 0 ? cycles >> shift_ : cycles / from_; }

  std::uint64_t to_, from_;
  int shift_;  // log2 of from_; -1 if that is no power of two
};

// Time of `cycles` cycles of `khz`, rounded down to a picosecond; exact if the period is a whole number of picoseconds.
constexpr Picoseconds cycles_to_ps(std::uint64_t cycles, std::uint64_t khz) {
  constexpr std::uint64_t kPicosecondsPerKhz = 1'000'000'000;  // length of a 1 kHz period
  // Whole milliseconds first, so that the product stays within 64 bits.
  return cycles / khz * kPicosecondsPerKhz + cycles % khz * kPicosecondsPerKhz / khz;
}

}  // namespace gicube::emu

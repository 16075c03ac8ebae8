// Random words for tests of value functions.
#pragma once

#include <cstdint>
#include <random>

namespace gicube::emu {

inline constexpr int kMany = 1'000'000;

// Whole numbers from `low` to `high`, its ends often.
class Words {
 public:
  explicit Words(unsigned seed) : random_(seed) {}
  std::int64_t operator()(std::int64_t low, std::int64_t high) {
    const std::uint64_t kind = random_() % 16;
    if (kind == 0) return low;
    if (kind == 1) return high;
    return low + static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(high - low + 1));
  }
  std::uint32_t u32(std::int64_t low, std::int64_t high) { return static_cast<std::uint32_t>((*this)(low, high)); }
  std::uint16_t u16(std::int64_t low, std::int64_t high) { return static_cast<std::uint16_t>((*this)(low, high)); }
  std::int16_t i16(std::int64_t low, std::int64_t high) { return static_cast<std::int16_t>((*this)(low, high)); }

 private:
  std::mt19937_64 random_;
};

}  // namespace gicube::emu

// Takes a fuzzer's bytes apart, from the front; past the end there are zeros.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "targets.h"

namespace gicube::fuzz {

class Input {
 public:
  explicit Input(Bytes bytes) : rest_(bytes) {}

  bool empty() const { return rest_.empty(); }
  std::size_t left() const { return rest_.size(); }

  template <typename Number>
  Number take() {
    Number number{};
    const std::size_t count = std::min(sizeof(Number), rest_.size());
    if (count > 0) std::memcpy(&number, rest_.data(), count);
    rest_ = rest_.subspan(count);
    return number;
  }
  std::uint8_t u8() { return take<std::uint8_t>(); }
  std::uint16_t u16() { return take<std::uint16_t>(); }
  std::uint32_t u32() { return take<std::uint32_t>(); }
  std::uint64_t u64() { return take<std::uint64_t>(); }
  std::uint32_t below(std::uint32_t bound) { return u8() % bound; }

  // `count` bytes, or as many as there are.
  std::vector<std::uint8_t> bytes(std::size_t count) {
    const Bytes taken = rest_.first(std::min(count, rest_.size()));
    rest_ = rest_.subspan(taken.size());
    return {taken.begin(), taken.end()};
  }

  // Mostly numbers that mean something in a volume of some voxels; the others are any double at all.
  double number() {
    static constexpr std::array kTelling{0.0, 1.0, -1.0, 0.5, 7.0, 3.5, 1e-3, -0.0, 1e9, 1e300, 1e-300, 4095.0, -1e18};
    const std::uint8_t kind = u8();
    if (kind < kTelling.size()) return kTelling[kind];
    if (kind == 255) return take<double>();
    if (kind == 254) return std::numeric_limits<double>::quiet_NaN();
    if (kind == 253) return std::numeric_limits<double>::infinity();
    return (kind - 128) / 8.0;
  }

 private:
  Bytes rest_;
};

}  // namespace gicube::fuzz

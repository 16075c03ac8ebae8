// Little-endian words and bit fields in plain byte arrays: the one place where the wire's byte order is decided.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace gicube::wire {

// Stores the low `sizeof(T)` bytes of `value` at `at`, least significant byte first.
template <typename T>
constexpr void store(std::span<std::uint8_t> bytes, std::size_t at, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
}

template <typename T>
constexpr T load(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::uint64_t{bytes[at + i]} << (8 * i);
  return static_cast<T>(value);
}

// A double travels as the 64 bits of its IEEE 754 form.
inline void store_double(std::span<std::uint8_t> bytes, std::size_t at, double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  store(bytes, at, bits);
}

inline double load_double(std::span<const std::uint8_t> bytes, std::size_t at) {
  const auto bits = load<std::uint64_t>(bytes, at);
  double value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

// A record of Words x 64 bits addressed by bit: bit 0 is the least significant bit of byte 0.
template <std::size_t Words>
struct BitRecord {
  std::array<std::uint64_t, Words> words{};

  // `value` must fit in `width` bits (1..32); a field may cross a word boundary.
  constexpr void put(unsigned offset, unsigned width, std::uint32_t value) {
    const std::uint64_t mask = (std::uint64_t{1} << width) - 1;
    const std::uint64_t bits = value & mask;
    const unsigned word = offset / 64, shift = offset % 64;
    words[word] |= bits << shift;
    if (shift + width > 64) words[word + 1] |= bits >> (64 - shift);
  }

  constexpr std::uint32_t get(unsigned offset, unsigned width) const {
    const std::uint64_t mask = (std::uint64_t{1} << width) - 1;
    const unsigned word = offset / 64, shift = offset % 64;
    std::uint64_t bits = words[word] >> shift;
    if (shift + width > 64) bits |= words[word + 1] << (64 - shift);
    return static_cast<std::uint32_t>(bits & mask);
  }
};

// Reads a two's-complement field of `width` bits.
constexpr std::int32_t sign_extend(std::uint32_t bits, unsigned width) {
  const std::uint32_t sign = std::uint32_t{1} << (width - 1);
  return static_cast<std::int32_t>((bits ^ sign) - sign);
}

}  // namespace gicube::wire

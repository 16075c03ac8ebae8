// Little-endian words and bit fields in byte arrays. The byte order of the wire is defined only here.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace gicube::wire {

// Stores a number or an enumeration at `at`, least significant byte first. Floats are stored as their IEEE 754 bits.
template <typename T>
constexpr void store(std::span<std::uint8_t> bytes, std::size_t at, T value) {
  std::uint64_t word = 0;
  if constexpr (std::is_same_v<T, double>) {
    word = std::bit_cast<std::uint64_t>(value);
  } else if constexpr (std::is_same_v<T, float>) {
    word = std::bit_cast<std::uint32_t>(value);
  } else {
    word = static_cast<std::uint64_t>(value);
  }
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes[at + i] = static_cast<std::uint8_t>(word >> (8 * i));
}

template <typename T>
constexpr T load(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) word |= std::uint64_t{bytes[at + i]} << (8 * i);
  if constexpr (std::is_same_v<T, double>) {
    return std::bit_cast<double>(word);
  } else if constexpr (std::is_same_v<T, float>) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(word));
  } else {
    return static_cast<T>(word);
  }
}

// A record of `Words` 64-bit words, addressed by bit. Bit 0 is the least significant bit of byte 0.
template <std::size_t Words>
struct BitRecord {
  std::array<std::uint64_t, Words> words{};

  // Stores the low `width` bits (1..32) of `value`. A field may cross a word boundary.
  constexpr void put(unsigned offset, unsigned width, std::uint32_t value) {
    const std::uint64_t bits = value & ((std::uint64_t{1} << width) - 1);
    const unsigned word = offset / 64, shift = offset % 64;
    words[word] |= bits << shift;
    if (shift + width > 64) words[word + 1] |= bits >> (64 - shift);
  }

  constexpr std::uint32_t get(unsigned offset, unsigned width) const {
    const unsigned word = offset / 64, shift = offset % 64;
    std::uint64_t bits = words[word] >> shift;
    if (shift + width > 64) bits |= words[word + 1] << (64 - shift);
    return static_cast<std::uint32_t>(bits & ((std::uint64_t{1} << width) - 1));
  }
};

// Converts a two's-complement field of `width` bits.
constexpr std::int32_t sign_extend(std::uint32_t bits, unsigned width) {
  const std::uint32_t sign = std::uint32_t{1} << (width - 1);
  return static_cast<std::int32_t>((bits ^ sign) - sign);
}

}  // namespace gicube::wire

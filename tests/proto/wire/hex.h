// Bytes as hex text and back: "DE AD 01", spaces between bytes, upper case.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gicube::wire {

inline std::string to_hex(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    if (!text.empty()) text += ' ';
    text += {kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return text;
}

template <std::size_t Size, typename Record>
std::array<std::uint8_t, Size> encoded(const Record& record) {
  std::array<std::uint8_t, Size> bytes;
  bytes.fill(0xEE);  // an encoder that forgets a byte is found out
  encode(record, std::span<std::uint8_t, Size>(bytes));
  return bytes;
}

template <std::size_t Size, typename Record>
std::string hex_of(const Record& record) {
  return to_hex(encoded<Size>(record));
}

}  // namespace gicube::wire

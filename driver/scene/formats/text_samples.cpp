#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <type_traits>

#include <fmt/format.h>

#include "scene/formats/data_stream.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {
namespace {

constexpr std::size_t kLongestNumber = 400;  // chosen: characters; a double written out in full has about 330

std::ifstream open_text(const std::filesystem::path& file, std::uint64_t offset, std::uint64_t min_bytes) {
  const std::uint64_t all = file_bytes(file);
  const std::uint64_t left = all > offset ? all - offset : 0;
  if (left < min_bytes) {
    throw FileError(file, "data", fmt::format("at least {} characters", min_bytes),
                    fmt::format("{} (truncated, or the header is wrong)", left));
  }
  std::ifstream input(file, std::ios::binary);
  if (!input) throw FileError(file, "file", "a readable file", "one that can't be opened");
  input.seekg(static_cast<std::streamoff>(offset));
  return input;
}

// The characters of the next number, at most kLongestNumber + 1; empty at the end of the file.
std::string next_word(std::istream& input) {
  while (input.peek() == ',' || std::isspace(input.peek())) input.get();
  std::string word;
  while (word.size() <= kLongestNumber) {
    const int next = input.peek();
    if (next == std::istream::traits_type::eof() || next == ',' || std::isspace(next)) break;
    word += static_cast<char>(input.get());
  }
  return word;
}

// False: the type cannot hold the value.
bool store_as(StoredType type, std::byte* at, double value) {
  return with_sample(type, [at, value](auto sample) {
    using Sample = decltype(sample);
    if constexpr (std::is_integral_v<Sample>) {
      // The upper end is exclusive: 2^63 and 2^64 are doubles, their predecessors are not.
      const double end = std::ldexp(1.0, std::numeric_limits<Sample>::digits);
      const double begin = std::is_signed_v<Sample> ? -end : 0;
      if (!(value >= begin && value < end) || value != std::floor(value)) return false;
    }
    sample = static_cast<Sample>(value);
    std::memcpy(at, &sample, sizeof sample);
    return true;
  });
}

bool parse(const std::string& word, double& value) {
  if (word.size() > kLongestNumber) return false;
  const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
  const char* end = word.data() + word.size();
  const auto result = std::from_chars(begin, end, value);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace

std::vector<std::byte> read_numbers(const std::filesystem::path& file, std::uint64_t offset, StoredType type,
                                    std::size_t count) {
  // Each number has at least a digit, and separators are between them.
  std::ifstream input = open_text(file, offset, 2 * std::uint64_t{count} - 1);
  std::vector<std::byte> samples(count * bytes_of(type));
  for (std::size_t i = 0; i < count; ++i) {
    const std::string word = next_word(input);
    if (word.empty()) throw FileError(file, "data", fmt::format("{} numbers", count), fmt::format("{}", i));
    double value = 0;
    if (!parse(word, value) || !store_as(type, samples.data() + i * bytes_of(type), value)) {
      throw FileError(file, fmt::format("sample {}", i), "a number that the sample type can hold",
                      '"' + word.substr(0, 40) + '"');
    }
  }
  return samples;
}

std::vector<std::byte> read_hex(const std::filesystem::path& file, std::uint64_t offset, std::size_t bytes) {
  std::ifstream input = open_text(file, offset, 2 * std::uint64_t{bytes});
  std::vector<std::byte> samples(bytes);
  for (std::size_t digit = 0; digit < 2 * bytes;) {
    const int next = input.get();
    if (next == std::istream::traits_type::eof()) {
      throw FileError(file, "data", fmt::format("{} hexadecimal digits", 2 * bytes), fmt::format("{}", digit));
    }
    if (std::isspace(next)) continue;
    const char text = static_cast<char>(next);
    std::uint8_t value = 0;
    if (std::from_chars(&text, &text + 1, value, 16).ec != std::errc()) {
      throw FileError(file, fmt::format("digit {}", digit), "0..9 or a..f", fmt::format("character code {}", next));
    }
    samples[digit / 2] = (samples[digit / 2] << 4) | static_cast<std::byte>(value);
    ++digit;
  }
  return samples;
}

}  // namespace gicube::scene

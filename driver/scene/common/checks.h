// Checks of user input: numbers in texts, bounds of values, and faults of parts, which are reported for the whole.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gicube/scene/error.h"
#include "gicube/vector.h"

namespace gicube::scene {

constexpr std::string_view kBlank = " \t\r\n\v\f";

inline std::string_view trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  return text.substr(0, text.find_last_not_of(kBlank) + 1);
}

// Converts ASCII letters in every locale: tolower('I') is not 'i' in a Turkish one.
inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

inline bool is_utf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  for (std::size_t i = 0, bytes = 1; i < text.size(); i += bytes) {
    const unsigned lead = byte(i), second = byte(i + 1);
    bytes = lead < 0x80 ? 1 : lead < 0xc2 ? 0 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : lead < 0xf5 ? 4 : 0;
    for (std::size_t rest = 1; rest < bytes; ++rest) {
      if ((byte(i + rest) & 0xc0) != 0x80) return false;
    }
    // Longer forms than need be, surrogates, numbers above U+10FFFF.
    const bool is_none = (lead == 0xe0 && second < 0xa0) || (lead == 0xed && second > 0x9f) ||
                         (lead == 0xf0 && second < 0x90) || (lead == 0xf4 && second > 0x8f);
    if (bytes == 0 || is_none) return false;
  }
  return true;
}

inline std::string in_quotes(std::string_view text) {
  std::string result(1, '"');
  result.append(text);
  result.push_back('"');
  return result;
}

// The faults of a part at `place`: their texts begin with `place` and `between`, and so do their fields, unless the
// fault is in another file.
inline std::vector<Fault> within(const std::string& place, const InputError& error, const char* between = ": ") {
  std::vector<Fault> faults = error.faults();
  for (Fault& fault : faults) {
    if (fault.file.empty()) fault.field = place + (fault.field.empty() ? "" : ".") + fault.field;
    fault.text = place + between + fault.text;
  }
  return faults;
}

// The number that the whole text is; nothing if it is not one of this type.
template <typename Number>
std::optional<Number> parse_number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// The words of a text, separated by white space.
inline std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t end = 0, begin; (begin = text.find_first_not_of(kBlank, end)) != text.npos;) {
    end = std::min(text.find_first_of(kBlank, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
  }
  return words;
}

inline Vec3 unit_or_zero(Vec3 v) { return length(v) > 0 ? (1 / length(v)) * v : Vec3{}; }
inline std::array<double, 3> in_order(Vec3 v) { return {v.x, v.y, v.z}; }
inline bool is_finite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

inline std::string shown(double value) { return fmt::format("{}", value); }
inline std::string shown_point(Vec3 v) { return fmt::format("{} {} {}", v.x, v.y, v.z); }

// These throw InputError that names `field`.
inline void require(bool good, const char* field, const char* expected, double got) {
  if (!good) throw InputError(field, expected, shown(got));
}
inline void require_above_0(const char* field, double value) {
  require(value > 0 && std::isfinite(value), field, "a number above 0", value);
}
inline void require_finite(const char* field, Vec3 v) {
  if (!is_finite(v)) throw InputError(field, "finite numbers", shown_point(v));
}

// Reports something suspicious about a file to the WarningHandler.
void warn(const std::filesystem::path& file, const std::string& field, const std::string& expected,
          const std::string& got);

// The value of this name. Throws InputError with `field` and all valid names.
template <typename Value, std::size_t Count>
Value named(const std::string& field, std::string_view name, const std::pair<const char*, Value> (&values)[Count]) {
  std::string names;
  for (std::size_t i = 0; i < Count; ++i) {
    if (name == values[i].first) return values[i].second;
    names += (i == 0 ? "" : i + 1 < Count ? ", " : " or ") + std::string(values[i].first);
  }
  throw InputError(field, names, in_quotes(name));
}

}  // namespace gicube::scene

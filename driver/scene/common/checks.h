// What a user wrote: numbers out of a text, and values within their bounds; faults of a part as those of the whole.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gicube/scene/error.h"
#include "gicube/vector.h"

namespace gicube::scene {

inline std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

inline std::string in_quotes(std::string_view text) {
  std::string result(1, '"');
  result.append(text);
  result.push_back('"');
  return result;
}

// The faults of `place`'s part: their texts begin with PLACE and `between`, and their fields are those of `place` unless a file of
// its own has them.
inline std::vector<Fault> within(const std::string& place, const InputError& error, const char* between = ": ") {
  std::vector<Fault> faults = error.faults();
  for (Fault& fault : faults) {
    if (fault.file.empty()) fault.field = place + (fault.field.empty() ? "" : ".") + fault.field;
    fault.text = place + between + fault.text;
  }
  return faults;
}

// Nothing unless the whole text is a number of this type.
template <typename Number>
std::optional<Number> parse_number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Parted by white space.
inline std::vector<std::string_view> words_of(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n\v\f";
  std::vector<std::string_view> words;
  for (std::size_t end = 0, begin; (begin = text.find_first_not_of(kBlank, end)) != text.npos;) {
    end = std::min(text.find_first_of(kBlank, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
  }
  return words;
}

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

// The value of this name. Throws InputError that names `field` and all that there are.
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

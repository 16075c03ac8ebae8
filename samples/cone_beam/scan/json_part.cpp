#include "cone_beam/scan/json_part.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "scene/formats/data_stream.h"
#include "scene/formats/file_error.h"

namespace gicube::samples {
namespace {

constexpr std::uint64_t kMaxBytes = 16 << 20;  // chosen: far above any description of a scan
constexpr int kMaxNesting = 100;               // chosen: copies and texts of deeper values would need much stack

}  // namespace

JsonPart::JsonPart(const std::filesystem::path& file) : file_(file) {
  if (const auto bytes = file_bytes(file); bytes > kMaxBytes) {
    throw FileError(file, "file", "at most 16 MiB", fmt::format("{} bytes", bytes));
  }
  std::ifstream stream(file);
  const auto check_depth = [&](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
    if (depth > kMaxNesting)
      throw FileError(file, "file", fmt::format("at most {} levels of nesting", kMaxNesting), "more");
    return true;
  };
  try {
    json_ = nlohmann::json::parse(stream, check_depth);
  } catch (const nlohmann::json::parse_error& error) {
    throw FileError(file, fmt::format("byte {}", error.byte), "JSON", error.what());
  } catch (const nlohmann::json::out_of_range& error) {
    throw FileError(file, "file", "numbers that a double holds", error.what());
  }
}

JsonPart JsonPart::at(const std::string& key) const {
  const std::string name = name_.empty() ? key : name_ + "." + key;
  if (!json_.is_object() || !json_.contains(key)) throw FileError(file_, name, "a value", "none");
  return {file_, name, json_[key]};
}

bool JsonPart::has(const std::string& key) const {
  return json_.is_object() && json_.contains(key) && !json_[key].is_null();
}

std::string JsonPart::text() const {
  if (!json_.is_string()) fault("a text");
  return json_.get<std::string>();
}

bool JsonPart::boolean() const {
  if (!json_.is_boolean()) fault("true or false");
  return json_.get<bool>();
}

double JsonPart::number() const {
  if (!json_.is_number() || !std::isfinite(json_.get<double>())) fault("a finite number");
  return json_.get<double>();
}

int JsonPart::whole(int low, int high) const {
  const double value = json_.is_number() ? json_.get<double>() : low - 1.0;
  if (!(value >= low && value <= high) || value != std::floor(value)) {
    fault(fmt::format("a whole number from {} to {}", low, high));
  }
  return static_cast<int>(value);
}

double JsonPart::with_unit(const std::vector<std::pair<const char*, double>>& units) const {
  if (json_.is_number()) return number();
  const double value = at("value").number();
  if (!has("unit")) return value;
  const std::string unit = at("unit").text();
  std::string known;
  for (const auto& [name, size] : units) {
    if (unit == name) return value * size;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  at("unit").fault("one of " + known);
}

double JsonPart::length() const { return with_unit({{"mm", 1}, {"nm", 1e-6}, {"um", 1e-3}, {"cm", 10}, {"m", 1000}}); }

double JsonPart::angle() const {
  const double degree = std::numbers::pi / 180;
  const bool plain = json_.is_number() || !has("unit");  // degrees are the format's own unit
  return (plain ? degree : 1) * with_unit({{"deg", degree}, {"rad", 1}});
}

int JsonPart::pixels() const {
  constexpr int kMax = 1 << 16;  // chosen
  if (json_.is_number()) return whole(1, kMax);
  if (has("unit") && at("unit").text() != "px") at("unit").fault("px");
  return at("value").whole(1, kMax);
}

void JsonPart::fault(const std::string& expected) const {
  std::string got = json_.dump();
  if (got.size() > 80) got = got.substr(0, 77) + "...";
  fault(expected, got);
}

void JsonPart::fault(const std::string& expected, const std::string& got) const {
  throw FileError(file_, name_.empty() ? "file" : name_, expected, got);
}

}  // namespace gicube::samples

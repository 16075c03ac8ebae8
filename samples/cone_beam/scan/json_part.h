// A JSON value that knows its own name, for messages.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace gicube::samples {

class JsonPart {
 public:
  // The whole file, which must outlive its parts. Throws FileError: no such file, no JSON.
  explicit JsonPart(const std::filesystem::path& file);

  JsonPart at(const std::string& key) const;  // throws FileError if it isn't there
  bool has(const std::string& key) const;     // there, and not null
  std::size_t size() const { return json_.size(); }

  // Each throws FileError: another type, out of range.
  std::string text() const;
  bool boolean() const;
  double number() const;  // finite
  int whole(int low, int high) const;
  // Of {"value": .., "unit": ".."}: millimetres, radians, pixels (a whole number from 1 on). A bare number is one too.
  double length() const;
  double angle() const;
  int pixels() const;

  [[noreturn]] void fault(const std::string& expected) const;  // "got" is the value itself
  [[noreturn]] void fault(const std::string& expected, const std::string& got) const;
  const std::filesystem::path& file() const { return file_; }

 private:
  JsonPart(std::filesystem::path file, std::string name, nlohmann::json json)
      : file_(std::move(file)), name_(std::move(name)), json_(std::move(json)) {}
  double with_unit(const std::vector<std::pair<const char*, double>>& units) const;

  std::filesystem::path file_;
  std::string name_;
  nlohmann::json json_;
};

}  // namespace gicube::samples

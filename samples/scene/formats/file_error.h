// What was wrong with a file that a sample program read or wrote.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace gicube::samples {

// Its text is "FILE: FIELD: expected ..., got ...".
class FileError : public std::runtime_error {
 public:
  FileError(const std::filesystem::path& file, const std::string& field, const std::string& expected,
            const std::string& got)
      : std::runtime_error(file.string() + ": " + field + ": expected " + expected + ", got " + got), field_(field) {}

  const std::string& field() const { return field_; }

 private:
  std::string field_;
};

}  // namespace gicube::samples

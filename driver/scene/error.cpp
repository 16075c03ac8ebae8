#include "gicube/scene/error.h"

#include <utility>

#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

Fault fault_of(const std::string& file, const std::string& field, const std::string& expected, const std::string& got) {
  const std::string text = field + ": expected " + expected + ", got " + got;
  return {file, 0, field, expected, got, file.empty() ? text : file + ": " + text};
}

std::string lines_of(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) text += (text.empty() ? "" : "\n") + fault.text;
  return text;
}

WarningHandler& warning_handler() {
  static WarningHandler handler;
  return handler;
}

}  // namespace

void set_warning_handler(WarningHandler handler) { warning_handler() = std::move(handler); }

void warn(const std::filesystem::path& file, const std::string& field, const std::string& expected,
          const std::string& got) {
  if (warning_handler()) warning_handler()(fault_of(file.string(), field, expected, got).text);
}

InputError::InputError(std::vector<Fault> faults) : Error(lines_of(faults)), faults_(std::move(faults)) {}

InputError::InputError(const std::string& field, const std::string& expected, const std::string& got)
    : InputError(std::vector{fault_of("", field, expected, got)}) {}

FileError::FileError(const std::filesystem::path& file, const std::string& field, const std::string& expected,
                     const std::string& got)
    : InputError(std::vector{fault_of(file.string(), field, expected, got)}) {}

}  // namespace gicube::scene

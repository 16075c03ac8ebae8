// Something that the user wrote, in a file or on the command line, is wrong.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace gicube::samples {

// what() may have several lines, one a problem.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  InputError(const std::string& field, const std::string& expected, const std::string& got)
      : std::runtime_error(field + ": expected " + expected + ", got " + got) {}
};

inline std::string in_quotes(std::string_view text) {
  std::string result(1, '"');
  result.append(text);
  result.push_back('"');
  return result;
}

}  // namespace gicube::samples

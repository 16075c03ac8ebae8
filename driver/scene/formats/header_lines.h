// The text header of a volume file, whose data may follow it in the same file.
#pragma once

#include <locale.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gicube::scene {

struct HeaderLines {
  std::vector<std::string> lines;  // the last one included, without line ends
  std::uint64_t end = 0;           // byte of the file behind the last line
  bool complete = false;           // whether the last line was found before the end of the file
};

// Reads lines up to the first for which is_last(line) holds. Throws FileError if the file cannot be read, or if there
// is more than a mebibyte without such a line.
HeaderLines read_header_lines(const std::filesystem::path& file, const std::function<bool(std::string_view)>& is_last);

// The data file that a header's field names, within the limits of NamedFiles. Throws FileError.
std::filesystem::path beside(const std::filesystem::path& header, const std::string& field, std::string_view name,
                             bool allow_outside);

// The data files that a header names by `pattern`: "LIST", or a name with a %d, its first and last number and the step.
// `list`: the lines after the header. Throws FileError.
std::vector<std::filesystem::path> series_of(const std::filesystem::path& file, const std::string& field,
                                             std::string_view pattern, std::span<const std::string> list,
                                             bool allow_outside);

// During its lifetime, this thread's C library uses a decimal point in numbers, in every locale of the application.
class DecimalPoint {
 public:
  DecimalPoint() : own_(::newlocale(LC_ALL_MASK, "C", nullptr)), before_(::uselocale(own_)) {}
  DecimalPoint(const DecimalPoint&) = delete;
  DecimalPoint& operator=(const DecimalPoint&) = delete;
  ~DecimalPoint() {
    ::uselocale(before_);
    ::freelocale(own_);
  }

 private:
  locale_t own_, before_;
};

}  // namespace gicube::scene

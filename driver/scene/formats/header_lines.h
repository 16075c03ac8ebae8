// The text header of a volume file, whose data may follow it in the same file.
#pragma once

#include <locale.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace gicube::scene {

struct HeaderLines {
  std::vector<std::string> lines;  // the last one included, without line ends
  std::uint64_t end = 0;           // byte of the file behind the last line
  bool complete = false;           // `is_last` was met; else the file ended
};

// Reads lines up to the first for which is_last(line) holds. Throws FileError when the file can't be read or its first
// mebibyte has no such line.
HeaderLines read_header_lines(const std::filesystem::path& file, const std::function<bool(std::string_view)>& is_last);

// The data file that a header's field names, as NamedFiles has it. Throws FileError.
std::filesystem::path beside(const std::filesystem::path& header, const std::string& field, std::string_view name,
                             bool allow_outside);

// During its lifetime, this thread's C library reads and writes numbers with a point, whatever locale the application
// has set.
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

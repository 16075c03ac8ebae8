#include "scene/text_file.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "scene/program/input_error.h"

namespace gicube::samples {

std::string read_text(const std::filesystem::path& file, const std::string& kind, std::uintmax_t max_mib) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw InputError(file.string(), kind, "no such file");
  if (const auto bytes = std::filesystem::file_size(file, error); bytes > max_mib << 20) {
    throw InputError(file.string(), fmt::format("{} of at most {} MiB", kind, max_mib), fmt::format("{} bytes", bytes));
  }
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw InputError(file.string(), kind, "one that can't be read");
  return text.str();
}

}  // namespace gicube::samples

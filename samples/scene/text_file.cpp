#include "scene/text_file.h"

#include <fstream>
#include <sstream>

#include "scene/program/input_error.h"

namespace gicube::samples {

std::string read_text(const std::filesystem::path& file, const std::string& what) {
  constexpr std::uintmax_t kMaxBytes = 1 << 20;  // chosen: far above any scene or transfer function
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw InputError(file.string(), what, "no such file");
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  if (bytes > kMaxBytes) throw InputError(file.string(), what + " of at most 1 MiB", std::to_string(bytes) + " bytes");
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw InputError(file.string(), what, "one that can't be read");
  return text.str();
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream stream(file);
  stream << text;
  stream.close();
  if (!stream) throw InputError(file.string(), "a file that can be written", "an error");
}

std::string csv_cell(const std::string& cell) {
  if (cell.find_first_of(",\"\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace gicube::samples

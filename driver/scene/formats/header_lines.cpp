#include "scene/formats/header_lines.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "scene/formats/data_stream.h"

namespace gicube::scene {
namespace {

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;  // chosen

}  // namespace

HeaderLines read_header_lines(const std::filesystem::path& file, const std::function<bool(std::string_view)>& is_last) {
  const std::string text = file_start(file, kMaxHeaderBytes);
  HeaderLines header;
  while (header.end < text.size() && !header.complete) {
    const std::size_t line_end = std::min(text.find('\n', header.end), text.size());
    std::string_view line(text.data() + header.end, line_end - header.end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    header.end = std::min(line_end + 1, text.size());
    header.lines.emplace_back(line);
    header.complete = is_last(line);
  }
  if (!header.complete && text.size() == kMaxHeaderBytes) {
    throw FileError(file, "header", fmt::format("its end within {} bytes", kMaxHeaderBytes), "none");
  }
  return header;
}

std::filesystem::path beside(const std::filesystem::path& header, const std::string& field, std::string_view name,
                             bool allow_outside) {
  namespace fs = std::filesystem;
  const fs::path file = header.parent_path() / fs::path(name);
  if (allow_outside) return file;
  std::error_code no_folder, no_file;
  const fs::path folder = fs::canonical(header.has_parent_path() ? header.parent_path() : ".", no_folder);
  const fs::path meant = fs::weakly_canonical(file, no_file);
  const bool inside = std::mismatch(folder.begin(), folder.end(), meant.begin(), meant.end()).first == folder.end();
  if (no_folder || no_file || !inside) {
    throw FileError(header, field, "a file in the header's folder or below (or --allow-outside)",
                    '"' + std::string(name) + '"');
  }
  return file;
}

}  // namespace gicube::scene

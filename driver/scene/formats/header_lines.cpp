#include "scene/formats/header_lines.h"

#include <algorithm>

#include <fmt/format.h>

#include "scene/common/named_files.h"
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
  try {
    return NamedFiles{header.parent_path(), allow_outside}.file(field, name);
  } catch (const InputError& error) {
    throw FileError(header, field, error.expected(), error.got());
  }
}

}  // namespace gicube::scene

#include "scene/formats/header_lines.h"

#include <algorithm>

#include <fmt/format.h>

#include "gicube/scene/volume_file.h"
#include "scene/common/named_files.h"
#include "scene/formats/data_stream.h"

namespace gicube::scene {
namespace {

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;  // chosen

// The names that "data file: FORMAT MIN MAX STEP [SUBDIM]" stands for. FORMAT has one number as printf writes it,
// "%03d"; printf itself never gets it.
std::vector<std::string> numbered_names(const std::filesystem::path& file, const std::string& field,
                                        std::string_view pattern) {
  const auto fault = [&] {
    return FileError(file, field, "a name with one %d and its first and last number and step", in_quotes(pattern));
  };
  const auto words = words_of(pattern);
  std::size_t numbers = 0;
  while (numbers < words.size() && numbers < 4 && parse_number<std::int32_t>(words[words.size() - 1 - numbers]))
    ++numbers;
  if (numbers < 2) throw fault();
  const auto number = [&](std::size_t i) { return *parse_number<std::int32_t>(words[words.size() - numbers + i]); };
  const std::int64_t low = number(0), high = number(1), step = numbers > 2 ? number(2) : 1;
  const std::string_view name =
      trimmed(pattern.substr(0, static_cast<std::size_t>(words[words.size() - numbers].data() - pattern.data())));
  const std::size_t begin = name.find('%'), end = begin == name.npos ? begin : name.find('d', begin);
  if (end == name.npos || name.find('%', end) != name.npos || end - begin > 4) throw fault();
  std::string_view width = name.substr(begin + 1, end - begin - 1);
  const bool zeros = width.starts_with('0');
  const auto digits = width.empty() ? std::optional(0) : parse_number<int>(width);
  if (!digits || *digits < 0 || step == 0 || (high - low) / step < 0 || (high - low) / step >= kMaxFileDim)
    throw fault();
  std::vector<std::string> names;
  for (std::int64_t i = low; step > 0 ? i <= high : i >= high; i += step) {
    const std::string text = zeros ? fmt::format("{:0{}}", i, *digits) : fmt::format("{:{}}", i, *digits);
    names.push_back(std::string(name.substr(0, begin)) + text + std::string(name.substr(end + 1)));
  }
  return names;
}

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

std::vector<std::filesystem::path> series_of(const std::filesystem::path& file, const std::string& field,
                                             std::string_view pattern, std::span<const std::string> list,
                                             bool allow_outside) {
  const std::vector<std::string> names = pattern.starts_with("LIST")
                                             ? std::vector<std::string>(list.begin(), list.end())
                                             : numbered_names(file, field, pattern);
  std::vector<std::filesystem::path> files;
  for (const std::string& name : names) {
    if (!trimmed(name).empty()) files.push_back(beside(file, field, trimmed(name), allow_outside));
  }
  if (files.empty() || files.size() > kMaxFileDim)
    throw FileError(file, field, fmt::format("1..{} files", kMaxFileDim), fmt::format("{}", files.size()));
  return files;
}

}  // namespace gicube::scene

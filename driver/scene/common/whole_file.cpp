#include "scene/common/whole_file.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

#include "gicube/scene/error.h"

namespace gicube::scene {
namespace {

InputError unreadable(const std::filesystem::path& file, const std::string& expected, const std::string& got) {
  const std::string text = fmt::format("{}: expected {}, got {}", file.string(), expected, got);
  return InputError({Fault{file.string(), 0, "file", expected, got, text}});
}

}  // namespace

std::string read_text(const std::filesystem::path& file, const std::string& kind, std::uintmax_t max_mib) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw unreadable(file, kind, "no such file");
  const auto bytes = std::filesystem::file_size(file, error);
  if (!error && bytes > max_mib << 20) {
    throw unreadable(file, fmt::format("{} of at most {} MiB", kind, max_mib), fmt::format("{} bytes", bytes));
  }
  std::string text(error ? 0 : bytes, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (error || !stream) throw unreadable(file, kind, "one that can't be read");
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // editors put it in front of UTF-8
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  return text;
}

void WholeFiles::write(const std::filesystem::path& path, const std::function<void(WholeFile&)>& fill) {
  try {
    WholeFile& file = files_.emplace_back(path, path).second;
    fill(file);
    file.close();
  } catch (const std::system_error& error) {
    throw FileError(path, "file", "a place to write to", error.code().message());
  }
}

void WholeFiles::write(const std::filesystem::path& path, std::string_view text) {
  write(path, [text](WholeFile& file) { file.write(text); });
}

void WholeFiles::commit() {
  for (auto& [path, file] : files_) {
    try {
      file.commit();
    } catch (const std::system_error& error) {
      throw FileError(path, "file", "a place to write to", error.code().message());
    }
  }
}

void write_whole(const std::filesystem::path& path, const std::function<void(WholeFile&)>& fill) {
  WholeFiles files;
  files.write(path, fill);
  files.commit();
}

void write_whole(const std::filesystem::path& path, std::string_view text) {
  write_whole(path, [text](WholeFile& file) { file.write(text); });
}

}  // namespace gicube::scene

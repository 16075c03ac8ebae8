#include "scene/common/whole_file.h"

#include <fmt/format.h>

#include <fstream>
#include <random>

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
  return text;
}

WholeFile::WholeFile(const std::filesystem::path& final_path) : final_(final_path), path_(final_path) {
  std::random_device random;
  path_.replace_filename(fmt::format(".{}.{:08x}.part", final_path.filename().string(), random()));
}

WholeFile::~WholeFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void WholeFile::rename() const {
  std::error_code fault;
  std::filesystem::rename(path_, final_, fault);
  if (fault) throw FileError(final_, "file", "a place to write to", fault.message());
}

void write_whole(const std::filesystem::path& path, const std::function<void(std::ostream&)>& fill) {
  const WholeFile whole(path);
  std::ofstream stream(whole.path(), std::ios::binary);
  fill(stream);
  stream.close();
  if (!stream) throw FileError(path, "file", "a place to write to", "an error");
  whole.rename();
}

void write_whole(const std::filesystem::path& path, std::string_view text) {
  write_whole(path, [text](std::ostream& stream) { stream << text; });
}

}  // namespace gicube::scene

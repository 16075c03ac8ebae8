#include "scene/formats/whole_file.h"

#include <fmt/format.h>

#include <fstream>
#include <random>

namespace gicube::samples {

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

}  // namespace gicube::samples

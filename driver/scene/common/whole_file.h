// Small files that are read whole, and files that are written whole (gicube/whole_file.h): who reads one sees the old
// contents or all of the new.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "gicube/scene/error.h"
#include "gicube/whole_file.h"

namespace gicube::scene {

// The text of a file, without a byte order mark. Throws InputError: it does not exist, is larger, or cannot be read.
// `kind` names the expected kind of file.
std::string read_text(const std::filesystem::path& file, const std::string& kind, std::uintmax_t max_mib = 1);

// Files that belong together: all of them, or none. Its calls throw FileError.
class WholeFiles {
 public:
  // Writes the output of `fill`, or the text.
  void write(const std::filesystem::path& path, const std::function<void(WholeFile&)>& fill);
  void write(const std::filesystem::path& path, std::string_view text);
  // Renames all of them to their final names.
  void commit();

 private:
  std::deque<std::pair<std::filesystem::path, WholeFile>> files_;
};

// One file. Throws FileError.
void write_whole(const std::filesystem::path& path, const std::function<void(WholeFile&)>& fill);
void write_whole(const std::filesystem::path& path, std::string_view text);

}  // namespace gicube::scene

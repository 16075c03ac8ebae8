// Small files that are read whole, and files that are written whole: who reads one sees the old contents or all of the new.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>

#include "gicube/scene/error.h"

namespace gicube::scene {

// A file that a user wrote. Throws InputError: it is not there, is larger, or can't be read; `kind` says what it was to be.
std::string read_text(const std::filesystem::path& file, const std::string& kind, std::uintmax_t max_mib = 1);

// A temporary file beside the final one, deleted unless rename() was called.
class WholeFile {
 public:
  explicit WholeFile(const std::filesystem::path& final_path);
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  ~WholeFile();

  const std::filesystem::path& path() const { return path_; }  // to be written

  // Throws FileError.
  void rename() const;

 private:
  std::filesystem::path final_, path_;
};

// What `fill` writes to the (binary) stream, or this text. Throws FileError.
void write_whole(const std::filesystem::path& path, const std::function<void(std::ostream&)>& fill);
void write_whole(const std::filesystem::path& path, std::string_view text);

}  // namespace gicube::scene

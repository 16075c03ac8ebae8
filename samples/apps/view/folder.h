// A folder for files of this run, which no other user can read and which is removed at the end.
#pragma once

#include <filesystem>
#include <string>

#include "scene/names.h"

namespace gicube::samples::view {

class PrivateFolder {
 public:
  // Below $TMPDIR or /tmp. Throws FileError.
  PrivateFolder();
  ~PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void remove() const;

 private:
  std::filesystem::path path_;
};

// The contents of a file; empty if it cannot be read.
std::string bytes_of(const std::filesystem::path& file);

}  // namespace gicube::samples::view

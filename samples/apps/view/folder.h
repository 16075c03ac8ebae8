// A folder for files of this run, which nobody else can read and which ends with it.
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

// All of a file; empty where it can't be read.
std::string bytes_of(const std::filesystem::path& file);

}  // namespace gicube::samples::view

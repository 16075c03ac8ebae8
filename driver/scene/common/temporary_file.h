// A file of this process alone.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

#include "gicube/scene/error.h"

namespace gicube::scene {

// An empty file in the folder for temporary ones, which only this user can read. It is removed with this object.
class TemporaryFile {
 public:
  // Throws FileError.
  TemporaryFile() {
    std::error_code none;
    std::string name = (std::filesystem::temp_directory_path(none) / "gicube-XXXXXX").string();
    const int fd = ::mkstemp(name.data());
    if (fd < 0) throw FileError(name, "file", "a place for a temporary file", std::strerror(errno));
    ::close(fd);
    path_ = name;
  }
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace gicube::scene

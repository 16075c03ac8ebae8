// A file that is there whole or not at all.
#pragma once

#include <filesystem>

#include "scene/formats/file_error.h"

namespace gicube::samples {

// Stands beside the final one, and is gone again unless it was renamed.
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

}  // namespace gicube::samples

#include "view/folder.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "gicube/scene/error.h"

namespace gicube::samples::view {

PrivateFolder::PrivateFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "gicube-view-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw FileError(name, "folder", "one that can be made", std::strerror(errno));
  path_ = name;
}

PrivateFolder::~PrivateFolder() { remove(); }

void PrivateFolder::remove() const {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace gicube::samples::view

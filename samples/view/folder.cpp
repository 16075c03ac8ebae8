#include "view/folder.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>

#include "gicube/scene/error.h"

namespace gicube::samples::view {

PrivateFolder::PrivateFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "gicube-view-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw FileError(name, "folder", "one that can be made", std::strerror(errno));
  path_ = name;
}

PrivateFolder::~PrivateFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace gicube::samples::view

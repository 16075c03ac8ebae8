#include "scene/formats/pictures/picture_library.h"

#include <dlfcn.h>

#include "gicube/scene/error.h"
#include "scene/common/plug_in.h"

namespace gicube::scene {

const void* plug_in(const std::filesystem::path& file, const std::string& name) {
  std::string error;
  void* const open = function_in(name, "gicube_" + name, RTLD_NOW | RTLD_LOCAL, error);
  if (open == nullptr) throw FileError(file, "format", "one that does not need libgicube-" + name + ".so", error);
  return reinterpret_cast<const void* (*)()>(open)();
}

const PictureLibrary& picture_library(const std::filesystem::path& file) {
  static const void* const library = plug_in(file, "pictures");
  return *static_cast<const PictureLibrary*>(library);
}

std::vector<std::uint8_t> encoded_picture(const std::filesystem::path& file, const PictureToWrite& picture) {
  std::string error;
  std::vector<std::uint8_t> bytes = picture_library(file).encode(file, picture, error);
  if (bytes.empty()) throw FileError(file, "picture", "one that OpenImageIO can write", error);
  return bytes;
}

}  // namespace gicube::scene

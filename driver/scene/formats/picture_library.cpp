#include "scene/formats/picture_library.h"

#include <dlfcn.h>

#include "gicube/scene/error.h"

namespace gicube::scene {
namespace {

constexpr const char* kLibrary = "libgicube-pictures.so." GICUBE_SOVERSION;

// The file of the shared object that has this code. Of a program this is how it was called, which need not be a path.
std::filesystem::path own_file() {
  static const char here = 0;
  Dl_info found{};
  return ::dladdr(&here, &found) != 0 && found.dli_fname != nullptr ? found.dli_fname : "";
}

// Beside libgicube-scene.so, or where a program's libraries are, installed or in the build tree; else where the system looks.
void* load() {
  for (const std::filesystem::path& own : {own_file(), std::filesystem::path("/proc/self/exe")}) {
    for (const char* const folder : {".", GICUBE_PROGRAMS_TO_LIBRARIES, "../lib"}) {
      std::error_code none;
      const std::filesystem::path file = std::filesystem::canonical(own, none).parent_path() / folder / kLibrary;
      if (file.is_absolute() && std::filesystem::exists(file, none))
        return ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    }
  }
  return ::dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
}

}  // namespace

const PictureLibrary& picture_library(const std::filesystem::path& file) {
  static void* const library = load();
  void* const open = library != nullptr ? ::dlsym(library, "gicube_pictures") : nullptr;
  if (open == nullptr) {
    const char* const why = ::dlerror();
    throw FileError(file, "image", std::string("one that can be read or written without ") + kLibrary,
                    why != nullptr ? why : "the library can't be loaded");
  }
  return *reinterpret_cast<const PictureLibrary* (*)()>(open)();
}

std::vector<std::uint8_t> encoded_picture(const std::filesystem::path& file, const PictureToWrite& picture) {
  std::string error;
  std::vector<std::uint8_t> bytes = picture_library(file).encode(file, picture, error);
  if (bytes.empty()) throw FileError(file, "picture", "one that OpenImageIO can write", error);
  return bytes;
}

}  // namespace gicube::scene

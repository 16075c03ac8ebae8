#include "scene/formats/pictures/picture_library.h"

#include <dlfcn.h>

#include "gicube/scene/error.h"
#include "scene/formats/plug_in.h"

namespace gicube::scene {
namespace {

// The file of the shared object with this code. For a program it is argv[0], which need not be a path.
std::filesystem::path own_file() {
  static const char here = 0;
  Dl_info found{};
  return ::dladdr(&here, &found) != 0 && found.dli_fname != nullptr ? found.dli_fname : "";
}

// Loads it from beside libgicube-scene.so, or from the libraries of the program, installed or in the build tree,
// otherwise from the system's search path.
void* load(const std::string& library) {
  for (const std::filesystem::path& own : {own_file(), std::filesystem::path("/proc/self/exe")}) {
    for (const char* const folder : {".", GICUBE_PROGRAMS_TO_LIBRARIES, "../lib"}) {
      std::error_code none;
      const std::filesystem::path file = std::filesystem::canonical(own, none).parent_path() / folder / library;
      if (file.is_absolute() && std::filesystem::exists(file, none))
        return ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    }
  }
  return ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
}

}  // namespace

const void* plug_in(const std::filesystem::path& file, const std::string& name) {
  const std::string library = "libgicube-" + name + ".so." GICUBE_SOVERSION;
  void* const loaded = load(library);
  void* const open = loaded != nullptr ? ::dlsym(loaded, ("gicube_" + name).c_str()) : nullptr;
  if (open != nullptr) return reinterpret_cast<const void* (*)()>(open)();
  const char* const why = ::dlerror();
  throw FileError(file, "format", "one that does not need " + library,
                  why != nullptr ? why : "the library can't be loaded");
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

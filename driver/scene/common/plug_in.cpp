#include "scene/common/plug_in.h"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>

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
void* load(const std::string& library, int flags) {
  for (const std::filesystem::path& own : {own_file(), std::filesystem::path("/proc/self/exe")}) {
    for (const char* const folder : {".", GICUBE_PROGRAMS_TO_LIBRARIES, "../lib"}) {
      std::error_code none;
      const std::filesystem::path file = std::filesystem::canonical(own, none).parent_path() / folder / library;
      if (file.is_absolute() && std::filesystem::exists(file, none)) return ::dlopen(file.c_str(), flags);
    }
  }
  return ::dlopen(library.c_str(), flags);
}

}  // namespace

void* function_in(const std::string& name, const std::string& function, int flags, std::string& error) {
  void* const loaded = load("libgicube-" + name + ".so." GICUBE_SOVERSION, flags);
  void* const found = loaded != nullptr ? ::dlsym(loaded, function.c_str()) : nullptr;
  if (found != nullptr) return found;
  const char* const why = ::dlerror();
  error = why != nullptr ? why : "the library cannot be loaded";
  return nullptr;
}

}  // namespace gicube::scene

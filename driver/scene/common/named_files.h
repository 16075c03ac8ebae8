// Files named by a text that may be from anyone, such as the meshes of a scene or the data of a header.
#pragma once

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"

namespace gicube::scene {

struct NamedFiles {
  std::filesystem::path folder;  // of the text; relative names are relative to it
  bool allow_outside = false;    // the text is trusted

  // The file of that name. Throws InputError that names `field` if, after following links, the file is neither in the
  // folder nor below, unless `allow_outside` is set. The error does not reveal whether such a file exists.
  std::filesystem::path file(const std::string& field, std::string_view name) const {
    namespace fs = std::filesystem;
    const fs::path file = folder / fs::path(name);
    if (allow_outside) return file;
    std::error_code no_folder, no_file;
    const fs::path here = fs::current_path(no_folder);
    const fs::path own = fs::weakly_canonical(here / folder / "", no_folder) / "";  // ends with a slash
    const fs::path meant = fs::weakly_canonical(here / file, no_file) / "";
    const bool inside =
        std::mismatch(own.begin(), std::prev(own.end()), meant.begin(), meant.end()).first == std::prev(own.end());
    if (no_folder || no_file || !inside)
      throw InputError(field, "a file in this file's folder or below (or --allow-outside)", in_quotes(name));
    return file;
  }
};

}  // namespace gicube::scene

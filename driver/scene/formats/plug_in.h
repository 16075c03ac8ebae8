// Shared objects that are loaded when a file first needs them, because they depend on large libraries
// (driver/scene/pictures, driver/scene/libraries).
#pragma once

#include <filesystem>
#include <string>

namespace gicube::scene {

// The result of gicube_NAME() of libgicube-NAME.so. Throws FileError for `file` if there is none.
const void* plug_in(const std::filesystem::path& file, const std::string& name);

}  // namespace gicube::scene

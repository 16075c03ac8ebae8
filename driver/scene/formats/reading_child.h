// Reading a file in a child process, for libraries that a damaged file can crash or make allocate any amount of memory
// (HDF5, OpenVDB).
#pragma once

#include <filesystem>
#include <functional>

#include "scene/formats/volume_library.h"

namespace gicube::scene {

// Returns the result of `read`, called in a child process. Throws FileError for a crash, or if reading needs more
// memory or time than the file's size justifies.
LibraryVolume read_in_child(const std::filesystem::path& file, const std::function<LibraryVolume()>& read);

}  // namespace gicube::scene

// A process that reads a file for this one: of libraries that damaged files can crash, or make take any amount of
// memory (HDF5, OpenVDB).
#pragma once

#include <filesystem>
#include <functional>

#include "scene/formats/volume_library.h"

namespace gicube::scene {

// Returns the result of `read`, called in a child of this process. A crash, and more memory or time than the file's
// size can explain, is a fault.
LibraryVolume read_in_child(const std::filesystem::path& file, const std::function<LibraryVolume()>& read);

}  // namespace gicube::scene

// MetaImage files: lines "Key = Value" up to ElementDataFile, which says where the data are.
#pragma once

#include <filesystem>

#include "scene/formats/volume_file.h"

namespace gicube::samples {

// The file's first lines read as a MetaImage header.
bool is_meta_image(const std::filesystem::path& file);

// Data in this file (LOCAL) or in one other; a LIST or numbered series of slice files is refused: give the folder or
// one file. Keys that say nothing of the samples' layout are ignored. MET_LONG has 4 bytes, as in MetaIO.
// Throws FileError.
Volume read_meta_image(const std::filesystem::path& file);

}  // namespace gicube::samples

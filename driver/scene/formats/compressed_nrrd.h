// Writing volumes of floats with one or three channels as NRRD.
#pragma once

#include <filesystem>

#include "gicube/scene/volume_file.h"

namespace gicube::scene {

// Writes a compressed NRRD. Throws FileError.
void write_compressed_nrrd(const FloatVolume& volume, const std::filesystem::path& path, const Provenance& provenance);

}  // namespace gicube::scene

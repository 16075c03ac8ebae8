// NRRD files: teem reads the header, from memory and without touching any data; the data are read here, once their
// size is known to be there.
#pragma once

#include <filesystem>

#include "scene/formats/volume_file.h"

namespace gicube::samples {

// The file begins as an NRRD of any version does.
bool is_nrrd(const std::filesystem::path& file);

// Throws FileError, also for what NRRD knows and this reader does not: several data files, bzip2 and zrl encodings,
// block samples, byte skips below -1 (-1 = data at the file's end).
// Axes of one sample may stand beside the three that count, wherever they are.
Volume read_nrrd(const std::filesystem::path& file);

// Voxels of one sample or, with a first axis of three and three more, of three: those of a row then follow each other, as a
// volume of three times as many voxels along x. `channels`: 1 or 3.
Volume read_nrrd_channels(const std::filesystem::path& file, int& channels);

}  // namespace gicube::samples

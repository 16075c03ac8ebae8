// NIfTI-1 and NIfTI-2 files, header and data in one, gzipped or not.
#pragma once

#include <filesystem>

#include "scene/formats/volume_file.h"

namespace gicube::samples {

// The file, or what is gzipped in it, begins with a NIfTI header of either byte order.
bool is_nifti(const std::filesystem::path& file);

// libnifti gives the header's layout and byte swapping. A scl_slope of 0 or NaN means "not scaled".
// Throws FileError, also for a header whose data lie in another file (.hdr and .img), colour and complex samples.
Volume read_nifti(const std::filesystem::path& file);

}  // namespace gicube::samples

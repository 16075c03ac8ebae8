// Image slices, a folder of them or the pages of one file, read by OpenImageIO.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <vector>

#include "scene/formats/volume_file.h"

namespace gicube::samples {

// Runs of digits count as numbers: "slice-2" before "slice-10". A strict order on names.
bool natural_less(std::string_view a, std::string_view b);
// The folder's files with one of these extensions (lower case; theirs in any), in natural order. Throws FileError.
std::vector<std::filesystem::path> files_with(const std::filesystem::path& folder,
                                              std::initializer_list<std::string_view> extensions);

// The folder's .png .tif .tiff .bmp .jpg .jpeg .pgm .exr files (any case) in natural order, the first at z = 0; x and y
// run as in the picture, from its upper left corner. Other files and folders in it are ignored. Samples are 8 or 16
// bits or float32, the same in all slices, and so are width and height; spacing is 1. Alpha is ignored; colour must be
// grey (red = green = blue). Throws FileError naming the slice.
Volume read_slices(const std::filesystem::path& folder);

// One such file, its pages as slices (TIFF; others have one).
Volume read_pages(const std::filesystem::path& file);

}  // namespace gicube::samples

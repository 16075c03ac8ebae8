// Stacks of views in files, and into files.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "cone_beam/scan/description.h"

namespace gicube::samples {

struct Stack {
  int columns = 0, rows = 0;
  std::vector<float> values;  // view by view, row by row as the files store them
  bool counts = false;        // they were whole numbers in the files

  std::size_t view_size() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  std::size_t views() const { return view_size() == 0 ? 0 : values.size() / view_size(); }
};

// All files' views, those of one file behind those of the one before. A raw file's views are as many as its bytes hold.
// Throws FileError: a file that can't be read, no whole number of views, views of different sizes, values that are not finite.
Stack read_stack(const StackFiles& files);

// By the extension: .nrrd, .mhd (with a .raw beside it), .mha or .raw (float32, little-endian) one file for all; .pfm, .tif or .tiff
// a file a view, NAME_0000.EXT beside `path`. Returns the files that a StackFiles names to read them again. Throws FileError.
std::vector<std::filesystem::path> write_stack(const Stack& stack, const std::filesystem::path& path);

// Portable float maps of one channel: "Pf", width and height, a scale whose sign says the byte order (below 0: little-endian) and
// whose size is ignored. Rows stay in the file's order, which the format's own description lets run upwards and writers of
// projections downwards. Throws FileError: no such file, no header of one channel, too few or too many bytes.
Stack read_pfm(const std::filesystem::path& file);
// Little-endian, scale 1. Throws FileError; a file that was there stays until the new one is whole.
void write_pfm(std::span<const float> values, int width, int height, const std::filesystem::path& file);

}  // namespace gicube::samples

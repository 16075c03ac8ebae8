// Portable float maps of one channel: "Pf", width and height, a scale whose sign says the byte order (below 0: little-endian).
// Rows stay in the file's order, which the format's own description lets run upwards and writers of projections downwards.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

namespace gicube::samples {

struct FloatMap {
  int width = 0, height = 0;
  std::vector<float> values;
};

// Throws FileError: no such file, no header of one channel, too few or too many bytes. The scale's size is ignored.
FloatMap read_pfm(const std::filesystem::path& file);
// Little-endian, scale 1. Throws FileError; a file that was there stays until the new one is whole.
void write_pfm(std::span<const float> values, int width, int height, const std::filesystem::path& file);

}  // namespace gicube::samples

// Pictures as numbers, and how far one is from another.
#pragma once

#include <filesystem>
#include <vector>

namespace gicube::samples::sweep {

// Display-referred red, green, blue, premultiplied, and alpha: 0..1, four a pixel, rows from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<float> values;
};

// Of an EXR as gicube-render writes it (linear light): the sRGB curve is applied again. Throws FileError.
Picture read_picture(const std::filesystem::path& file);

// Of another size, by the bilinear way between its pixels' centres.
Picture resized(const Picture& picture, int width, int height);

// Root of the mean square over all four channels of all pixels, peak 1; a picture of another size is resized to that of the
// reference first.
double rmse(const Picture& picture, const Picture& reference);

}  // namespace gicube::samples::sweep

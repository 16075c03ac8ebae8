// Writes pictures of the short samples as PPM files, which most viewers open.
#pragma once

#include <gicube/image.h>
#include <gicube/transfer_function.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

// Display-referred colours, 0..1, rows from the top.
inline void write_display_colours(const std::string& file, int width, const std::vector<gicube::Colour>& pixels) {
  std::ofstream out(file, std::ios::binary);
  out << "P6\n" << width << ' ' << pixels.size() / static_cast<std::size_t>(width) << "\n255\n";
  for (const gicube::Colour& pixel : pixels) {
    for (const double part : pixel) out.put(static_cast<char>(std::lround(255 * std::clamp(part, 0.0, 1.0))));
  }
}

// Linear light, such as radiances, where 1 is white; rows from the top.
inline void write_light(const std::string& file, int width, std::vector<gicube::Colour> pixels) {
  for (gicube::Colour& pixel : pixels) {
    for (double& part : pixel) part = std::pow(std::max(0.0, part), 1 / 2.2);  // close to the curve of sRGB
  }
  write_display_colours(file, width, pixels);
}

// A picture of the board over a grey background.
inline void write_image(const std::string& file, const gicube::Image& image, double background = 0.1) {
  std::vector<gicube::Colour> pixels;
  for (const gicube::Pixel& pixel : image.pixels) {
    const double behind = background * (1 - pixel.alpha / 4095.0);
    pixels.push_back({pixel.red / 255.0 + behind, pixel.green / 255.0 + behind, pixel.blue / 255.0 + behind});
  }
  write_display_colours(file, image.width, pixels);
}

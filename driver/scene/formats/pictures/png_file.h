// PNG files with eight bits per channel, in sRGB, by libpng.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace gicube::scene {

struct PngToWrite {
  int width = 0, height = 0;
  int channels = 0;                       // 3: red, green, blue; 4: and alpha, not premultiplied
  std::span<const std::uint8_t> samples;  // row by row, the channels of a pixel together
  std::vector<std::pair<std::string, std::string>> texts;
};

// The bytes of a file. Throws FileError that names the path.
std::vector<std::uint8_t> encoded_png(const std::filesystem::path& file, const PngToWrite& picture);

}  // namespace gicube::scene

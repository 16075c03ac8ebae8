// A picture read from the board's framebuffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gicube/export.h"

namespace gicube {

// Colour is premultiplied by alpha; 255 and 4095 are one. Display-referred (sRGB), as transfer functions are.
struct Pixel {
  std::uint8_t red = 0, green = 0, blue = 0;
  std::uint16_t alpha = 0;

  friend constexpr bool operator==(const Pixel&, const Pixel&) = default;
};

struct Image {
  int width = 0;
  int height = 0;
  std::vector<Pixel> pixels;  // width * height, rows from the top

  const Pixel& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
  friend bool operator==(const Image&, const Image&) = default;
};

}  // namespace gicube

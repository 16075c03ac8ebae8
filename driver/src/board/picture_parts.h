// Decodes pixels; joins a picture from the rows of several boards.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "gicube/image.h"
#include "gicube/view.h"
#include "gicube/wire/voxel.h"

namespace gicube {

// Also sets the padding byte of `out`, so that equal pictures have equal bytes.
inline void take_pixel(const wire::Pixel& pixel, Pixel& out) {
  std::memset(static_cast<void*>(&out), 0, sizeof out);
  out.red = pixel.red;
  out.green = pixel.green;
  out.blue = pixel.blue;
  out.alpha = pixel.alpha;
}

// Height of the strips of rows that boards make in turn, so that each gets expensive and cheap rows. With the tent
// filter, rays at a strip's edge are made for both neighbours: higher strips have fewer of them. `one_each`: one strip
// per board, for volumes in bricks, because each board must be sent all blocks that its rays need. Measured:
// docs/guide/boards.md.
inline std::uint16_t strip_rows(const View& view, std::size_t boards, bool one_each) {
  const int of_each = (view.height + static_cast<int>(boards) - 1) / static_cast<int>(boards);
  if (one_each) return static_cast<std::uint16_t>(of_each);
  constexpr int kHighest = 8, kStrips = 4;  // chosen: at most an eighth more rays; four strips per board balance well
  const bool twice = view.filter == PixelFilter::kTent && view.samples_per_axis > 1;
  return static_cast<std::uint16_t>(twice ? std::clamp(of_each / kStrips, 1, kHighest) : 1);
}

// Joins the picture from the rows that each board has made.
inline Image join_rows(int width, int height, std::uint16_t strip_rows, std::span<const Image> parts) {
  Image image{width, height, {}};
  image.pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::vector<std::size_t> taken(parts.size());  // pixels
  for (int row = 0; row < height; row += strip_rows) {
    const std::size_t from = static_cast<std::size_t>(row / strip_rows) % parts.size();
    const std::size_t pixels =
        static_cast<std::size_t>(std::min<int>(strip_rows, height - row)) * static_cast<std::size_t>(width);
    const auto first = parts[from].pixels.begin() + static_cast<std::ptrdiff_t>(taken[from]);
    image.pixels.insert(image.pixels.end(), first, first + static_cast<std::ptrdiff_t>(pixels));
    taken[from] += pixels;
  }
  return image;
}

}  // namespace gicube

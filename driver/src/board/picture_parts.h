// Pixels, and a picture whose rows several boards make.
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

// Also the byte between its members, so that equal pictures are equal as bytes.
inline void take_pixel(const wire::Pixel& pixel, Pixel& out) {
  std::memset(static_cast<void*>(&out), 0, sizeof out);
  out.red = pixel.red;
  out.green = pixel.green;
  out.blue = pixel.blue;
  out.alpha = pixel.alpha;
}

// Rows that are dealt in turn, so that no board has only what is costly. By a tent rays beside a strip have a part in
// it, and are made for both strips: higher ones have fewer of them. Boards that send themselves the blocks that their
// rays need get one strip each, which needs fewest. Measured: docs/guide/boards.md.
inline std::uint16_t strip_rows(const View& view, std::size_t boards, bool one_each) {
  const int of_each = (view.height + static_cast<int>(boards) - 1) / static_cast<int>(boards);
  if (one_each) return static_cast<std::uint16_t>(of_each);
  constexpr int kHighest = 8, kStrips = 4;  // chosen: at most an eighth more rays; four strips a board are even enough
  const bool twice = view.filter == PixelFilter::kTent && view.samples_per_axis > 1;
  return static_cast<std::uint16_t>(twice ? std::clamp(of_each / kStrips, 1, kHighest) : 1);
}

// The whole picture, of what each board has made, one below the other.
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

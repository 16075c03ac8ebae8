#include "cone_beam/program/slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/image_file.h"
#include "scene/program/input_error.h"

namespace gicube::samples {

Image slice_of(const Grid& grid, std::span<const float> values, int axis, int index,
               const std::array<double, 2>& grey) {
  const std::size_t across = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
  const std::array<std::size_t, 3> strides{
      1, static_cast<std::size_t>(grid.dims[0]),
      static_cast<std::size_t>(grid.dims[0]) * static_cast<std::size_t>(grid.dims[1])};
  Image image{grid.dims[across], grid.dims[up], {}};
  const std::size_t plane = static_cast<std::size_t>(index) * strides[static_cast<std::size_t>(axis)];
  for (int row = image.height - 1; row >= 0; --row) {
    for (int column = 0; column < image.width; ++column) {
      const double value = static_cast<double>(values[plane + static_cast<std::size_t>(row) * strides[up] +
                                                      static_cast<std::size_t>(column) * strides[across]]);
      const double part = std::clamp((value - grey[0]) / (grey[1] - grey[0]), 0.0, 1.0);
      const auto level = static_cast<std::uint8_t>(std::lround(255 * part));
      image.pixels.push_back({level, level, level, 4095});
    }
  }
  return image;
}

std::array<double, 2> grey_range(std::span<const float> values) {
  std::vector<float> sorted(values.begin(), values.end());
  const std::size_t tail = sorted.size() / 1000;
  const auto at = [&](std::size_t place) {
    std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(place));
    return static_cast<double>(sorted[place]);
  };
  const double low = at(tail), high = at(sorted.size() - 1 - tail);
  return {low, high > low ? high : low + 1};
}

std::vector<std::filesystem::path> write_slices(const SliceOptions& options, const Grid& grid,
                                                std::span<const float> values) {
  if (options.name.empty()) return {};
  const std::array<double, 2> grey = options.grey ? *options.grey : grey_range(values);
  auto planes = options.planes;
  const bool middle = planes.empty();
  for (int axis = 0; middle && axis < 3; ++axis)
    planes.emplace_back(axis, grid.dims[static_cast<std::size_t>(axis)] / 2);
  std::vector<std::filesystem::path> files;
  for (const auto& [axis, index] : planes) {
    const char letter = static_cast<char>('x' + axis);
    const int end = grid.dims[static_cast<std::size_t>(axis)];
    if (index >= end) {
      throw InputError(fmt::format("--slice {}", letter), fmt::format("0 to {}", end - 1), std::to_string(index));
    }
    files.emplace_back(fmt::format("{}_{}{}.png", options.name, letter, middle ? "" : std::to_string(index)));
    write_png(slice_of(grid, values, axis, index, grey), files.back(), Colour{0, 0, 0});
  }
  return files;
}

}  // namespace gicube::samples

// What commands read and write besides scans: phantoms, volumes, pictures of their slices.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cone_beam/program/options.h"
#include "scene/formats/volume_output.h"
#include "scene/image_file.h"
#include "scene/program/input_error.h"

namespace gicube::samples {

bool is_phantom(const ObjectOptions& object) { return object.name.starts_with("builtin:"); }

Phantom phantom_of(const ObjectOptions& object) {
  const auto times_value = [&object](Phantom phantom) {
    for (Ellipsoid& ellipsoid : phantom) ellipsoid.value *= object.value;
    return phantom;
  };
  if (object.name == "builtin:shepp-logan") return times_value(shepp_logan(object.radius));
  if (object.name == "builtin:shepp-logan-high-contrast") return times_value(high_contrast_shepp_logan(object.radius));
  if (object.name == "builtin:sphere") return uniform_sphere(object.radius, object.value);
  throw InputError("phantom", "builtin:shepp-logan, builtin:shepp-logan-high-contrast or builtin:sphere",
                   in_quotes(object.name));
}

GridValues read_values(const std::filesystem::path& file) {
  const Volume volume = read_volume(file);
  GridValues out{{volume.dims, volume.spacing}, values_of(volume)};
  const auto bad = std::ranges::find_if(out.values, [](float value) { return !std::isfinite(value); });
  if (bad != out.values.end()) {
    throw FileError(file, fmt::format("voxel {}", bad - out.values.begin()), "a finite value", fmt::format("{}", *bad));
  }
  return out;
}

void write_values(const Grid& grid, Vec3 centre, std::span<const float> values, const std::filesystem::path& file) {
  if (!file.empty()) write_volume({grid.dims, grid.spacing, centre + to_space(grid, {0, 0, 0}), values}, file);
}

void check_volume_name(const char* option, const std::filesystem::path& path) {
  if (path.empty() || is_volume_output(path)) return;
  throw UsageError(fmt::format("{}: expected a name that ends in .nrrd, .mhd, .mha, .nii or .nii.gz, got {}", option,
                               in_quotes(path.string())));
}

Image slice_of(const Grid& grid, std::span<const float> values, int axis, int index,
               const std::array<double, 2>& grey) {
  const std::size_t across = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
  const auto columns = static_cast<std::size_t>(grid.dims[0]), rows = static_cast<std::size_t>(grid.dims[1]);
  const std::array<std::size_t, 3> strides{1, columns, columns * rows};
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

void write_slices(const SliceOptions& options, const Grid& grid, std::span<const float> values) {
  if (options.name.empty()) return;
  const std::array<double, 2> grey = options.grey ? *options.grey : grey_range(values);
  auto planes = options.planes;
  const bool middle = planes.empty();
  if (middle) planes = {{0, grid.dims[0] / 2}, {1, grid.dims[1] / 2}, {2, grid.dims[2] / 2}};
  for (const auto& [axis, index] : planes) {
    const char letter = static_cast<char>('x' + axis);
    const int end = grid.dims[static_cast<std::size_t>(axis)];
    if (index >= end) {
      throw InputError(fmt::format("--slice {}", letter), fmt::format("0 to {}", end - 1), std::to_string(index));
    }
    write_png(slice_of(grid, values, axis, index, grey),
              fmt::format("{}_{}{}.png", options.name, letter, middle ? "" : std::to_string(index)), Colour{0, 0, 0});
  }
}

}  // namespace gicube::samples

#include "gicube/scene/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "scene/formats/plane_file.h"

namespace gicube::scene {
namespace {

constexpr double kVisible = 0.005;   // chosen: opacity of one voxel that is still seen as a haze over many
constexpr std::size_t kBins = 4096;  // as the board's densities

}  // namespace

SceneBox whole_box(const Dims& dims) { return {{}, {dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0}}; }

SceneBox visible_box(const Volume& volume, const TransferFunctionFile& file) {
  const Dims& dims = volume.dims;
  const ValueRange range = value_range_of(volume);
  if (!(range.low < range.high)) return whole_box(dims);
  const TransferFunction function = in_values_of(range, file);
  std::vector<char> visible(kBins);
  for (std::size_t i = 0; i < kBins; ++i) {
    const double value = range.low + (range.high - range.low) * static_cast<double>(i) / (kBins - 1);
    visible[i] = function.opacity_at(value) > kVisible;
  }
  const double scale = (kBins - 1) / (range.high - range.low);
  const auto seen = [&](double value) {
    const double bin = std::clamp((value - range.low) * scale, 0.0, kBins - 1.0);
    return bin >= 0 && visible[static_cast<std::size_t>(bin)] != 0;  // not-a-numbers are not
  };

  std::array<int, 3> low = dims, high{-1, -1, -1};
  for_each_plane(volume, [&](int z, std::span<const std::byte> samples) {
    with_sample(volume.type, [&](auto sample) {
      std::size_t row = 0;
      for (int y = 0; y < dims[1]; ++y, row += static_cast<std::size_t>(dims[0])) {
        const auto seen_at = [&](int x) {
          const std::size_t index = row + static_cast<std::size_t>(x);
          return seen(static_cast<double>(sample_at<decltype(sample)>(samples, index)));
        };
        int first = 0, last = dims[0] - 1;
        while (first <= last && !seen_at(first)) ++first;
        if (first > last) continue;
        while (!seen_at(last)) --last;
        low = {std::min(low[0], first), std::min(low[1], y), std::min(low[2], z)};
        high = {std::max(high[0], last), std::max(high[1], y), std::max(high[2], z)};
      }
    });
  });
  if (high[0] < 0) return whole_box(dims);
  const auto below = [&low](std::size_t axis) { return std::max(low[axis] - 1.0, 0.0); };
  const auto above = [&](std::size_t axis) { return std::min(high[axis] + 1.0, dims[axis] - 1.0); };
  return {{below(0), below(1), below(2)}, {above(0), above(1), above(2)}};
}

}  // namespace gicube::scene

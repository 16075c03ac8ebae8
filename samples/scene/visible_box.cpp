#include "scene/visible_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "scene/formats/stored_samples.h"

namespace gicube::samples {
namespace {

constexpr double kVisible = 0.005;   // chosen: opacity of one voxel that is still seen as a haze over many
constexpr std::size_t kBins = 4096;  // as the board's densities

using VisibleBins = std::array<bool, kBins>;

VisibleBins visible_bins(const TransferFunction& function, const ValueRange& range) {
  VisibleBins bins{};
  for (std::size_t i = 0; i < kBins; ++i) {
    const double value = range.low + (range.high - range.low) * static_cast<double>(i) / (kBins - 1);
    bins[i] = function.opacity_at(value) > kVisible;
  }
  return bins;
}

// Calls `visit(y, z, row)` for each row of samples along x, a span of the type's own numbers.
template <typename Sample, typename Visit>
void each_row(const Volume& volume, const Visit& visit) {
  std::vector<Sample> row(static_cast<std::size_t>(volume.dims[0]));
  const std::byte* next = volume.samples.data();
  for (int z = 0; z < volume.dims[2]; ++z) {
    for (int y = 0; y < volume.dims[1]; ++y, next += row.size() * sizeof(Sample)) {
      std::memcpy(row.data(), next, row.size() * sizeof(Sample));
      visit(y, z, std::span<const Sample>(row));
    }
  }
}

// Of numbers that are finite.
template <typename Sample>
void widen(std::span<const Sample> row, ValueRange& range) {
  if constexpr (std::is_integral_v<Sample>) {
    Sample low = row[0], high = row[0];
    for (const Sample value : row) low = std::min(low, value), high = std::max(high, value);
    range = {std::min(range.low, static_cast<double>(low)), std::max(range.high, static_cast<double>(high))};
  } else {
    for (const Sample value : row) {
      if (!std::isfinite(value)) continue;
      range = {std::min(range.low, double{value}), std::max(range.high, double{value})};
    }
  }
}

// Whether a value is seen: of integers each looked at once.
template <typename Sample>
class Seen {
 public:
  Seen(const VisibleBins& bins, const ValueRange& range) : bins_(bins), range_(range) {
    if constexpr (std::is_integral_v<Sample>) {
      for (int value = kMin; value <= std::numeric_limits<Sample>::max(); ++value) table_.push_back(of(value));
    }
  }
  bool operator()(Sample value) const {
    if constexpr (std::is_integral_v<Sample>) {
      return table_[static_cast<std::size_t>(value - kMin)];
    } else {
      return of(value);
    }
  }

 private:
  static constexpr int kMin = std::is_integral_v<Sample> ? static_cast<int>(std::numeric_limits<Sample>::lowest()) : 0;
  bool of(double value) const {
    const double scale = (kBins - 1) / (range_.high - range_.low);
    const double bin = std::clamp((value - range_.low) * scale, 0.0, kBins - 1.0);
    return bin >= 0 && bins_[static_cast<std::size_t>(bin)];
  }

  const VisibleBins& bins_;
  const ValueRange& range_;
  std::vector<char> table_;
};

}  // namespace

VoxelBox whole_box(const Dims& dims) { return {{}, {dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0}}; }

ValueRange value_range_of(const Volume& volume) {
  if (volume.range) return *volume.range;
  if (volume.type == SampleType::kUint8) return {0, 255};
  if (volume.type == SampleType::kUint12) return {0, 4095};
  ValueRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  with_sample(volume.type, [&]<typename Sample>(Sample) {
    each_row<Sample>(volume, [&range](int, int, std::span<const Sample> row) { widen(row, range); });
  });
  return range;
}

VoxelBox visible_box(const Volume& volume, const TransferFunctionFile& look) {
  const ValueRange range = value_range_of(volume);
  const VoxelBox whole = whole_box(volume.dims);
  if (!(range.low < range.high)) return whole;
  const VisibleBins bins = visible_bins(in_values_of(range, look), range);

  std::array<int, 3> low = volume.dims, high{-1, -1, -1};
  const auto look_at = [&]<typename Sample>(int y, int z, std::span<const Sample> row, const Seen<Sample>& seen) {
    const auto first = std::find_if(row.begin(), row.end(), std::cref(seen));
    if (first == row.end()) return;
    auto last = row.end() - 1;
    while (!seen(*last)) --last;
    const std::array<int, 3> lower{static_cast<int>(first - row.begin()), y, z};
    const std::array<int, 3> upper{static_cast<int>(last - row.begin()), y, z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], lower[axis]);
      high[axis] = std::max(high[axis], upper[axis]);
    }
  };
  const auto search = [&]<typename Sample>(Sample) {
    const Seen<Sample> seen(bins, range);
    each_row<Sample>(volume, [&](int y, int z, std::span<const Sample> row) { look_at(y, z, row, seen); });
  };
  with_sample(volume.type, search);
  if (high[0] < 0) return whole;
  const auto below = [&low](std::size_t axis) { return std::max(low[axis] - 1.0, 0.0); };
  const auto above = [&](std::size_t axis) { return std::min(high[axis] + 1.0, volume.dims[axis] - 1.0); };
  return {{below(0), below(1), below(2)}, {above(0), above(1), above(2)}};
}

}  // namespace gicube::samples

#include "common/visible_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

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

// Calls `visit(x, y, z, value)` for every sample.
template <typename Sample, typename Visit>
void each_sample(const Volume& volume, const Visit& visit) {
  const std::byte* next = volume.samples.data();
  for (int z = 0; z < volume.dims[2]; ++z) {
    for (int y = 0; y < volume.dims[1]; ++y) {
      for (int x = 0; x < volume.dims[0]; ++x, next += sizeof(Sample)) {
        Sample sample;
        std::memcpy(&sample, next, sizeof sample);
        visit(x, y, z, static_cast<double>(sample));
      }
    }
  }
}

template <typename Visit>
void each_value(const Volume& volume, const Visit& visit) {
  switch (volume.type) {
    case SampleType::kUint8: return each_sample<std::uint8_t>(volume, visit);
    case SampleType::kUint12:
    case SampleType::kUint16: return each_sample<std::uint16_t>(volume, visit);
    case SampleType::kInt16: return each_sample<std::int16_t>(volume, visit);
    case SampleType::kFloat32: return each_sample<float>(volume, visit);
  }
}

}  // namespace

VoxelBox whole_box(const Dims& dims) { return {{}, {dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0}}; }

ValueRange value_range_of(const Volume& volume) {
  if (volume.range) return *volume.range;
  if (volume.type == SampleType::kUint8) return {0, 255};
  if (volume.type == SampleType::kUint12) return {0, 4095};
  ValueRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  each_value(volume, [&range](int, int, int, double value) {
    if (!std::isfinite(value)) return;
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  });
  return range;
}

VoxelBox visible_box(const Volume& volume, const TransferFunctionFile& look) {
  const ValueRange range = value_range_of(volume);
  const VoxelBox whole = whole_box(volume.dims);
  if (!(range.low < range.high)) return whole;
  const VisibleBins bins = visible_bins(in_values_of(range, look), range);
  const double scale = (kBins - 1) / (range.high - range.low);

  std::array<int, 3> low = volume.dims, high{-1, -1, -1};
  each_value(volume, [&](int x, int y, int z, double value) {
    const double bin = std::clamp((value - range.low) * scale, 0.0, kBins - 1.0);
    if (!(bin >= 0) || !bins[static_cast<std::size_t>(bin)]) return;
    const std::array<int, 3> voxel{x, y, z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], voxel[axis]);
      high[axis] = std::max(high[axis], voxel[axis]);
    }
  });
  if (high[0] < 0) return whole;
  const auto lower = [&low](std::size_t axis) { return std::max(low[axis] - 1.0, 0.0); };
  const auto upper = [&](std::size_t axis) { return std::min(high[axis] + 1.0, volume.dims[axis] - 1.0); };
  return {{lower(0), lower(1), lower(2)}, {upper(0), upper(1), upper(2)}};
}

}  // namespace gicube::samples

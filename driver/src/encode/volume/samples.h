// Checks and reads a volume's samples, and converts them to the board's 12-bit densities.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "gicube/volume.h"

namespace gicube {

// Throws BadArgument naming the field and the first wrong voxel. `max_volume_voxels`: the board's largest volume edge.
void check_volume(const VolumeView& view, int max_volume_voxels);

// Checks a volume whose samples are read later: everything but the samples.
void check_shape(const VolumeView& view, int max_volume_voxels);
// Checks the samples only. `first_plane`: number of the view's first plane in a larger volume, for error messages.
void check_samples(const VolumeView& view, int first_plane = 0);

// The least and the greatest sample, which may be equal.
ValueRange extremes(const VolumeView& view);
// Whether the range does not depend on the samples.
bool has_range(const VolumeView& view);
// A range of one value v, of a constant volume, becomes v .. v + 1.
ValueRange with_span(ValueRange range);
// The view's range, or the default of volume.h. The view must have passed check_volume().
ValueRange resolve_range(const VolumeView& view);

// The voxel edges over the smallest of them: 1..64 each.
Vec3 relative_spacing(Vec3 spacing);

// Reads by memcpy, because the caller's memory, such as a mapped file, may be unaligned.
template <typename T>
class Samples {
 public:
  using Value = T;
  explicit Samples(const VolumeView& view) : bytes_(view.samples.data()) {}

  T operator[](std::size_t index) const {
    T value;
    std::memcpy(&value, bytes_ + index * sizeof(T), sizeof(T));
    return value;
  }

 private:
  const std::byte* bytes_;
};

// Calls f(Samples<T>) with the T that the view's type stands for.
template <typename F>
decltype(auto) with_samples(const VolumeView& view, F&& f) {
  switch (view.type) {
    case SampleType::kUint8: return std::forward<F>(f)(Samples<std::uint8_t>(view));
    case SampleType::kInt16: return std::forward<F>(f)(Samples<std::int16_t>(view));
    case SampleType::kFloat32: return std::forward<F>(f)(Samples<float>(view));
    case SampleType::kUint12:
    case SampleType::kUint16: break;
  }
  return std::forward<F>(f)(Samples<std::uint16_t>(view));
}

// Index of voxel (x, y, z), x fastest.
constexpr std::size_t index_of(Dims dims, int x, int y, int z) {
  return static_cast<std::size_t>(x) +
         static_cast<std::size_t>(dims[0]) *
             (static_cast<std::size_t>(y) + static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(z));
}
constexpr std::size_t index_of(Dims dims, Dims at) { return index_of(dims, at[0], at[1], at[2]); }
// The voxel with that index.
constexpr Dims position_of(std::size_t index, Dims dims) {
  const auto nx = static_cast<std::size_t>(dims[0]), ny = static_cast<std::size_t>(dims[1]);
  return {static_cast<int>(index % nx), static_cast<int>(index / nx % ny), static_cast<int>(index / nx / ny)};
}
// Calls take(voxel) for all with low <= voxel < end on each axis, in the order of their indices.
template <typename Take>
void for_each_position(Dims low, Dims end, const Take& take) {
  for (int z = low[2]; z < end[2]; ++z) {
    for (int y = low[1]; y < end[1]; ++y) {
      for (int x = low[0]; x < end[0]; ++x) take(Dims{x, y, z});
    }
  }
}

constexpr std::size_t voxel_count(Dims dims) {
  return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(dims[2]);
}

// Blocks of n^3 voxels that a volume of `dims` voxels has along each axis.
constexpr Dims block_grid(Dims dims, int n) {
  return {(dims[0] + n - 1) / n, (dims[1] + n - 1) / n, (dims[2] + n - 1) / n};
}

// Converts one value, as below.
std::uint16_t to_density(double value, ValueRange range);

// round(4095 (v - low) / (high - low)), clamped to 0..4095; one per voxel, x fastest. The view must be checked.
std::vector<std::uint16_t> to_densities(const VolumeView& view, ValueRange range);

}  // namespace gicube

// A volume's samples: whether they can go to the board, their values in the caller's memory, and the board's 12-bit
// densities.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "gicube/volume.h"

namespace gicube {

// Throws BadArgument naming the field, and the first wrong voxel. `max_volume_voxels`: the board's largest volume edge
// N.
void check_volume(const VolumeView& view, int max_volume_voxels);

// Checks a volume whose samples are read later: everything but the samples.
void check_shape(const VolumeView& view, int max_volume_voxels);
// The part of check_volume() that concerns samples alone. `first_plane`: the number of the first of these planes in a
// larger volume, for error messages.
void check_samples(const VolumeView& view, int first_plane = 0);

// The least and the greatest sample, which may be equal.
ValueRange extremes(const VolumeView& view);
// Whether the range does not depend on the samples.
bool has_range(const VolumeView& view);
// A constant volume of value v, which has no span of its own, gets v .. v + 1.
ValueRange with_span(ValueRange range);
// The view's own range, or the default that volume.h states. Only for a view that passed check_volume().
ValueRange resolve_range(const VolumeView& view);

// The voxel edges over the smallest of them: 1..64 each.
Vec3 relative_spacing(Vec3 spacing);

// Reads through memcpy, since a file mapped into memory need not be aligned.
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

constexpr std::size_t voxel_count(Dims dims) {
  return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(dims[2]);
}

// Converts one value, as below.
std::uint16_t to_density(double value, ValueRange range);

// round(4095 (v - low) / (high - low)), clamped to 0..4095; one a voxel, x fastest. For a checked view.
std::vector<std::uint16_t> to_densities(const VolumeView& view, ValueRange range);

}  // namespace gicube

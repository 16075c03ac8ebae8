// A volume's samples as numbers of their own type, wherever they stand in the caller's memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "gicube/volume.h"

namespace gicube {

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

constexpr std::size_t voxel_count(Dims dims) {
  return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(dims[2]);
}

}  // namespace gicube

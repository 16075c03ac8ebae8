#include "encode/volume/density.h"

#include <algorithm>
#include <limits>

#include "encode/volume/samples.h"
#include "gicube/wire/voxel.h"

namespace gicube {

std::uint16_t to_density(double value, ValueRange range) {
  const double density = wire::kDensityMax * (value - range.low) / (range.high - range.low);
  // floor((2 d + 1) / 2): rounds like lround, without a library call for each of millions of samples.
  return static_cast<std::uint16_t>(static_cast<int>(2 * std::clamp(density, 0.0, double{wire::kDensityMax}) + 1) / 2);
}

namespace {

std::vector<std::uint16_t> convert(Samples<float> samples, std::size_t count, ValueRange range) {
  std::vector<std::uint16_t> densities(count);
  for (std::size_t i = 0; i < count; ++i) densities[i] = to_density(samples[i], range);
  return densities;
}

// An integer type has few values: each is converted once.
template <typename T>
std::vector<std::uint16_t> convert(Samples<T> samples, std::size_t count, ValueRange range) {
  constexpr int low = std::numeric_limits<T>::min(), high = std::numeric_limits<T>::max();
  std::vector<std::uint16_t> table;
  for (int value = low; value <= high; ++value) table.push_back(to_density(value, range));
  std::vector<std::uint16_t> densities(count);
  for (std::size_t i = 0; i < count; ++i) densities[i] = table[static_cast<std::size_t>(samples[i] - low)];
  return densities;
}

}  // namespace

std::vector<std::uint16_t> to_densities(const VolumeView& view, ValueRange range) {
  return with_samples(view, [&](auto samples) { return convert(samples, voxel_count(view.dims), range); });
}

}  // namespace gicube

#include "encode/volume/samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "encode/argument.h"
#include "gicube/wire/registers.h"
#include "gicube/wire/voxel.h"

namespace gicube {
namespace {

constexpr unsigned kSpacingRatio = wire::kSpacingMax / wire::kSpacingOne;
constexpr double kLargest = 1e300;  // chosen: 4095 times any difference is still finite

constexpr std::array kTypeNames{"uint8", "uint12", "uint16", "int16", "float32"};  // by SampleType

std::string at_voxel(const char* field, std::size_t index, Dims dims, int first_plane = 0) {
  const auto [x, y, z] = position_of(index, dims);
  return fmt::format("{} at voxel ({}, {}, {})", field, x, y, z + first_plane);
}

const char* check_dims(const VolumeView& view, int max_volume_voxels) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    expect_within(fmt::format("dims[{}]", axis), view.dims[axis], 2, max_volume_voxels);
  }
  const auto number = static_cast<std::size_t>(view.type);
  expect(number < kTypeNames.size(), "type", "a SampleType", view.type);
  return kTypeNames[number];
}

void check_sizes(const VolumeView& view, const char* type) {
  const std::size_t count = voxel_count(view.dims), bytes = count * bytes_per_sample(view.type);
  const auto [x, y, z] = view.dims;
  const std::size_t samples = view.samples.size(), gradients = view.gradients.size(), tags = view.tags.size();
  expect(samples == bytes, "samples", fmt::format("{} bytes ({} x {} x {} of {})", bytes, x, y, z, type), samples);
  expect(gradients == 0 || gradients == 3 * count, "gradients",
         fmt::format("none or {} floats, 3 per voxel", 3 * count), gradients);
  const std::size_t colours = view.colours.size();
  expect(colours == 0 || colours == 3 * count, "colours", fmt::format("none or {} bytes, 3 per voxel", 3 * count),
         colours);
  expect(tags == 0 || tags == count, "tags", fmt::format("none or {}, one per voxel", count), tags);
}

void check_spacing(Vec3 spacing) {
  const std::map<std::string, double> axes{
      {"spacing.x", spacing.x}, {"spacing.y", spacing.y}, {"spacing.z", spacing.z}};
  for (const auto& [field, edge] : axes) {
    expect(edge > 0 && std::isfinite(edge), field, "a finite length above 0", edge);
  }
  const double smallest = std::min({spacing.x, spacing.y, spacing.z});
  const std::string expected = fmt::format("at most {} times the smallest edge {}", kSpacingRatio, smallest);
  for (const auto& [field, edge] : axes) expect(edge / smallest <= kSpacingRatio, field, expected, edge);
}

void check_gradients_and_tags(const VolumeView& view) {
  for (std::size_t i = 0; i < view.gradients.size(); ++i) {
    expect_finite([&] { return at_voxel("gradients", i / 3, view.dims); }, view.gradients[i]);
  }
  for (std::size_t i = 0; i < view.tags.size(); ++i) {
    if (view.tags[i] >= wire::kTags) expect_within(at_voxel("tags", i, view.dims), view.tags[i], 0, wire::kTags - 1);
  }
}

std::vector<std::uint16_t> convert(Samples<float> samples, std::size_t count, ValueRange range) {
  std::vector<std::uint16_t> densities(count);
  const double halves = 2 * wire::kDensityMax / (range.high - range.low);
  for (std::size_t i = 0; i < count; ++i) {
    // Twice the density by a product, which is faster than to_density()'s quotient. Near a whole number the two could
    // round differently.
    constexpr double kNear = 1e-6;
    const double value = samples[i], twice = (value - range.low) * halves;
    if (twice == 0) continue;
    const bool inside = twice > 0 && twice < 2 * wire::kDensityMax;
    const int whole = inside ? static_cast<int>(twice) : 0;
    const double rest = twice - whole;
    const bool is_safe = inside && rest > kNear && rest < 1 - kNear;
    densities[i] = is_safe ? static_cast<std::uint16_t>((whole + 1) / 2) : to_density(value, range);
  }
  return densities;
}

// Integer types have few values: a table converts each once.
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

void check_samples(const VolumeView& view, int first_plane) {
  const std::size_t count = voxel_count(view.dims);
  if (view.type == SampleType::kUint12) {
    const Samples<std::uint16_t> samples(view);
    for (std::size_t i = 0; i < count; ++i) {
      if (samples[i] > wire::kDensityMax) {
        expect_within(at_voxel("samples", i, view.dims, first_plane), samples[i], 0, wire::kDensityMax);
      }
    }
  }
  if (view.type == SampleType::kFloat32) {
    const Samples<float> samples(view);
    for (std::size_t i = 0; i < count; ++i) {
      expect_finite([&] { return at_voxel("samples", i, view.dims, first_plane); }, samples[i]);
    }
  }
}

void check_shape(const VolumeView& view, int max_volume_voxels) {
  check_dims(view, max_volume_voxels);
  check_spacing(view.spacing);
  const ValueRange range = view.range.value_or(ValueRange{});
  expect_within("range.low", range.low, -kLargest, kLargest);
  expect_within("range.high", range.high, -kLargest, kLargest);
  expect(range.low < range.high, "range.high", fmt::format("above range.low, {}", range.low), range.high);
}

void check_volume(const VolumeView& view, int max_volume_voxels) {
  check_sizes(view, check_dims(view, max_volume_voxels));
  check_shape(view, max_volume_voxels);
  check_samples(view);
  check_gradients_and_tags(view);
}

bool has_range(const VolumeView& view) {
  return view.range || view.type == SampleType::kUint8 || view.type == SampleType::kUint12;
}

ValueRange resolve_range(const VolumeView& view) {
  if (view.range) return *view.range;
  if (view.type == SampleType::kUint8) return {0, 255};
  if (view.type == SampleType::kUint12) return {0, wire::kDensityMax};
  return with_span(extremes(view));
}

ValueRange extremes(const VolumeView& view) {
  return with_samples(view, [count = voxel_count(view.dims)](auto samples) {
    auto low = samples[0], high = samples[0];
    for (std::size_t i = 1; i < count; ++i) {
      const auto value = samples[i];
      low = value < low ? value : low;
      high = value > high ? value : high;
    }
    return ValueRange{static_cast<double>(low), static_cast<double>(high)};
  });
}

ValueRange with_span(ValueRange range) {
  if (range.low < range.high) return range;
  // Beyond 2^53 adding 1 changes nothing: take the next larger number.
  return {range.low, std::max(range.low + 1, std::nextafter(range.low, std::numeric_limits<double>::infinity()))};
}

Vec3 relative_spacing(Vec3 spacing) {
  const double smallest = std::min({spacing.x, spacing.y, spacing.z});
  return {spacing.x / smallest, spacing.y / smallest, spacing.z / smallest};
}

std::uint16_t to_density(double value, ValueRange range) {
  const double density = wire::kDensityMax * (value - range.low) / (range.high - range.low);
  // floor((2 d + 1) / 2): rounds like lround, without a library call for each of millions of samples.
  return static_cast<std::uint16_t>(static_cast<int>(2 * std::clamp(density, 0.0, double{wire::kDensityMax}) + 1) / 2);
}

std::vector<std::uint16_t> to_densities(const VolumeView& view, ValueRange range) {
  return with_samples(view, [&](auto samples) { return convert(samples, voxel_count(view.dims), range); });
}

}  // namespace gicube

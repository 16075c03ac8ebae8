#include "field.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gicube::reference {

namespace {

constexpr double kDensityMax = 4095;
constexpr double kMinGradient = 1.0 / 8;  // density units a (smallest) voxel edge; less is no gradient
constexpr double kDensityEighths = 8;     // the 12.3 word
constexpr double kGradientFraction = 32;  // the five fraction bits of the interpolated gradient

Vec3 over(Vec3 a, Vec3 b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
bool is_zero(Vec3 v) { return v == Vec3{}; }

template <typename T>
std::vector<float> read_as(const VolumeView& volume, std::size_t count) {
  std::vector<T> samples(count);
  std::memcpy(samples.data(), volume.samples.data(), count * sizeof(T));
  return std::vector<float>(samples.begin(), samples.end());
}

std::vector<float> read(const VolumeView& volume) {
  const auto count = static_cast<std::size_t>(volume.dims[0]) * static_cast<std::size_t>(volume.dims[1]) *
                     static_cast<std::size_t>(volume.dims[2]);
  switch (volume.type) {
    case SampleType::kUint8: return read_as<std::uint8_t>(volume, count);
    case SampleType::kInt16: return read_as<std::int16_t>(volume, count);
    case SampleType::kFloat32: return read_as<float>(volume, count);
    case SampleType::kUint12:
    case SampleType::kUint16: break;
  }
  return read_as<std::uint16_t>(volume, count);
}

// The rule that volume.h promises.
ValueRange find_range(const VolumeView& volume, const std::vector<float>& values) {
  if (volume.range) return *volume.range;
  if (volume.type == SampleType::kUint8) return {0, 255};
  if (volume.type == SampleType::kUint12) return {0, kDensityMax};
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  if (*least == *greatest) return {*least, *least + 1.0};
  return {*least, *greatest};
}

// The eight voxels around a position and how far it is from the first, 0..1 along each axis.
struct Cell {
  std::array<int, 3> first{};
  std::array<double, 3> weight{};
};

Cell cell_at(Vec3 position, Dims dims) {
  Cell cell;
  const std::array<double, 3> p{position.x, position.y, position.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cell.first[axis] = std::clamp(static_cast<int>(std::floor(p[axis])), 0, dims[axis] - 2);
    cell.weight[axis] = p[axis] - cell.first[axis];
  }
  return cell;
}

// Along x, then y, then z, as the board's seven interpolators do it. `at(x, y, z)` gives a voxel's number, `mix` mixes
// two.
template <typename At, typename Mix>
auto trilinear(const Cell& cell, const At& at, const Mix& mix) {
  const int x = cell.first[0], y = cell.first[1], z = cell.first[2];
  const auto along_x = [&](int row, int plane) {
    return mix(at(x, row, plane), at(x + 1, row, plane), cell.weight[0]);
  };
  const auto along_y = [&](int plane) { return mix(along_x(y, plane), along_x(y + 1, plane), cell.weight[1]); };
  return mix(along_y(z), along_y(z + 1), cell.weight[2]);
}

double mix_exactly(double a, double b, double w) { return a + (b - a) * w; }
double mix_words(double a, double b, double w) { return a + std::floor((b - a) * w + 0.5); }

}  // namespace

ValueRange value_range(const VolumeView& volume) { return find_range(volume, read(volume)); }

Field::Field(const VolumeView& volume, const Quantisers& quantisers)
    : volume_(volume), quantisers_(quantisers), values_(read(volume)) {
  range_ = find_range(volume_, values_);
  const double smallest = std::min({volume.spacing.x, volume.spacing.y, volume.spacing.z});
  spacing_ = 1 / smallest * volume.spacing;
  if (quantisers.gradient) codebook_.emplace();
}

Sample Field::sample(Vec3 position) const {
  const Cell cell = cell_at(position, volume_.dims);
  const double span = range_.high - range_.low;
  const auto held = [this](int x, int y, int z) { return std::clamp(value(x, y, z), range_.low, range_.high); };
  if (!quantisers_.density) {
    const double v = trilinear(cell, held, mix_exactly);
    return {v, kDensityMax * ((v - range_.low) / span)};
  }
  const auto word = [&](int x, int y, int z) {
    return kDensityEighths * std::floor(kDensityMax * ((held(x, y, z) - range_.low) / span) + 0.5);
  };
  const double density = trilinear(cell, word, mix_words) / kDensityEighths;
  return {range_.low + density / kDensityMax * span, density};
}

int Field::tag(Vec3 position) const {
  if (volume_.tags.empty()) return 0;
  const auto nearest = [](double p) { return static_cast<int>(std::floor(p + 0.5)); };
  return volume_.tags[index(nearest(position.x), nearest(position.y), nearest(position.z))];
}

Vec3 Field::gradient(Vec3 position) const {
  const Cell cell = cell_at(position, volume_.dims);
  const auto component = [&](double Vec3::*axis) {
    const auto at = [&](int x, int y, int z) { return voxel_gradient(x, y, z).*axis; };
    if (!quantisers_.gradient) return trilinear(cell, at, mix_exactly);
    constexpr double kOne = wire::kGradientOne * kGradientFraction;
    const auto word = [&](int x, int y, int z) { return kOne * at(x, y, z); };
    return trilinear(cell, word, mix_words) / kOne;
  };
  return {component(&Vec3::x), component(&Vec3::y), component(&Vec3::z)};
}

Vec3 Field::voxel_gradient(int x, int y, int z) const {
  const Vec3 exact = true_gradient(x, y, z);
  if (is_zero(exact)) return {};
  if (!codebook_) return normalise(exact);
  const wire::GradientEntry& entry = codebook_->entries()[codebook_->nearest(exact)];
  return 1.0 / wire::kGradientOne *
         Vec3{static_cast<double>(entry[0]), static_cast<double>(entry[1]), static_cast<double>(entry[2])};
}

// The 3x3x3 Sobel filter: differences over two voxels, smoothed 1-2-1 along both other axes.
Vec3 Field::true_gradient(int x, int y, int z) const {
  if (!volume_.gradients.empty()) {
    const float* g = volume_.gradients.data() + 3 * index(x, y, z);
    return {g[0], g[1], g[2]};
  }
  constexpr std::array<double, 3> kSmooth{1, 2, 1}, kDifference{-1, 0, 1};
  Vec3 sum;
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j), c = static_cast<std::size_t>(k);
        const double v = value(x + i - 1, y + j - 1, z + k - 1);
        sum = sum + v * Vec3{kDifference[a] * kSmooth[b] * kSmooth[c], kSmooth[a] * kDifference[b] * kSmooth[c],
                             kSmooth[a] * kSmooth[b] * kDifference[c]};
      }
    }
  }
  constexpr double kWeight = 32;  // two voxels times (1 + 2 + 1)^2
  const Vec3 slope = over(kDensityMax / (range_.high - range_.low) / kWeight * sum, spacing_);
  return length(slope) < kMinGradient ? Vec3{} : slope;
}

double Field::value(int x, int y, int z) const {
  return values_[index(std::clamp(x, 0, volume_.dims[0] - 1), std::clamp(y, 0, volume_.dims[1] - 1),
                       std::clamp(z, 0, volume_.dims[2] - 1))];
}

std::size_t Field::index(int x, int y, int z) const {
  const auto nx = static_cast<std::size_t>(volume_.dims[0]), ny = static_cast<std::size_t>(volume_.dims[1]);
  return (static_cast<std::size_t>(z) * ny + static_cast<std::size_t>(y)) * nx + static_cast<std::size_t>(x);
}

}  // namespace gicube::reference

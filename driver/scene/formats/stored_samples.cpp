#include "scene/formats/stored_samples.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include <fmt/format.h>

namespace gicube::scene {
namespace {

// That hold each SampleType, in its order.
constexpr std::array kOwnTypes = {StoredType::kUint8, StoredType::kUint12, StoredType::kUint16, StoredType::kInt16,
                                  StoredType::kFloat32};

// The driver's type that holds the samples unchanged, if there is one.
std::optional<SampleType> kept_type(const StoredLayout& layout) {
  const auto* found = std::ranges::find(kOwnTypes, layout.type);
  if (layout.slope != 1 || layout.intercept != 0 || found == kOwnTypes.end()) return std::nullopt;
  return static_cast<SampleType>(found - kOwnTypes.begin());
}

void to_machine_order(std::span<std::byte> samples, const StoredLayout& layout) {
  const std::size_t size = bytes_of(layout.type);
  if (size == 1 || layout.big_endian == (std::endian::native == std::endian::big)) return;
  for (std::size_t i = 0; i < samples.size(); i += size) std::ranges::reverse(samples.subspan(i, size));
}

template <typename Sample>
std::vector<std::byte> scaled_floats(std::span<const std::byte> stored, const StoredLayout& layout) {
  const std::size_t count = stored.size() / sizeof(Sample);
  std::vector<std::byte> floats(count * sizeof(float));
  for (std::size_t i = 0; i < count; ++i) {
    const double exact = layout.slope * static_cast<double>(sample_at<Sample>(stored, i)) + layout.intercept;
    const float value = static_cast<float>(exact);
    if (!std::isfinite(value)) {
      throw FileError(layout.file, fmt::format("sample {}", layout.first_sample + i), "a finite 32-bit float",
                      fmt::format("{}", exact));
    }
    std::memcpy(floats.data() + i * sizeof(float), &value, sizeof(float));
  }
  return floats;
}

void check_12_bits(std::span<const std::byte> samples, const StoredLayout& layout) {
  for (std::size_t i = 0; i < samples.size() / 2; ++i) {
    const auto sample = sample_at<std::uint16_t>(samples, i);
    if (sample > 4095)
      throw FileError(layout.file, fmt::format("sample {}", layout.first_sample + i), "0..4095",
                      fmt::format("{}", sample));
  }
}

}  // namespace

std::size_t bytes_of(StoredType type) {
  return with_sample(type, [](auto sample) { return sizeof sample; });
}

StoredType stored_type(SampleType type) { return kOwnTypes.at(static_cast<std::size_t>(type)); }

Dims checked_dims(const std::filesystem::path& file, const std::string& field, std::span<const std::int64_t> sizes) {
  const std::string got = fmt::format("{}", fmt::join(sizes, " x "));
  if (sizes.size() < 3) throw FileError(file, field, "three axes", sizes.empty() ? "none" : got);
  Dims dims{};
  for (std::size_t axis = 0; axis < sizes.size(); ++axis) {
    const std::int64_t most = axis < 3 ? kMaxFileDim : 1;
    if (sizes[axis] < 1 || sizes[axis] > most) {
      throw FileError(file, field, fmt::format("three axes of 1..{} voxels, any further of 1", kMaxFileDim), got);
    }
    if (axis < 3) dims[axis] = static_cast<int>(sizes[axis]);
  }
  return dims;
}

bool is_kept(const StoredLayout& layout) { return kept_type(layout).has_value(); }

std::size_t checked_bytes(const StoredLayout& layout) {
  // At most 2^36 voxels of 8 bytes: no overflow.
  const std::uint64_t count = voxels_of(layout.dims);
  const std::size_t kept = kept_type(layout) ? bytes_of(layout.type) : sizeof(float);
  const std::uint64_t bytes = count * std::max(kept, bytes_of(layout.type));
  if (bytes > kMaxVolumeBytes) {
    throw FileError(layout.file, "size", fmt::format("at most {} bytes of samples", kMaxVolumeBytes),
                    fmt::format("{} ({})", bytes, fmt::join(layout.dims, " x ")));
  }
  return count * bytes_of(layout.type);
}

Volume to_volume(std::vector<std::byte> stored, const StoredLayout& layout) {
  Volume volume;
  volume.dims = layout.dims;
  volume.source = layout.file.string();
  volume.spacing = layout.spacing;
  to_machine_order(stored, layout);
  if (layout.type == StoredType::kUint12) check_12_bits(stored, layout);
  if (const auto kept = kept_type(layout)) {
    volume.type = *kept;
    volume.samples = std::move(stored);
    return volume;
  }
  volume.type = SampleType::kFloat32;
  volume.samples =
      with_sample(layout.type, [&](auto sample) { return scaled_floats<decltype(sample)>(stored, layout); });
  if (layout.type == StoredType::kUint8) {
    // Bytes keep the whole range that they have unscaled, 0..255, so that volumes of one series agree.
    const double ends[2] = {layout.intercept, 255 * layout.slope + layout.intercept};
    volume.range = ValueRange{std::min(ends[0], ends[1]), std::max(ends[0], ends[1])};
  }
  return volume;
}

}  // namespace gicube::scene

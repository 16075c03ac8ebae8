#include "scene/formats/stored_samples.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

// The stored type of each SampleType, in its order.
constexpr std::array kOwnTypes = {StoredType::kUint8, StoredType::kUint12, StoredType::kUint16, StoredType::kInt16,
                                  StoredType::kFloat32};

// The driver's type that holds the samples unchanged, if there is one.
std::optional<SampleType> kept_type(const StoredLayout& layout) {
  const auto* found = std::ranges::find(kOwnTypes, layout.type);
  if (layout.slope != 1 || layout.intercept != 0 || found == kOwnTypes.end()) return std::nullopt;
  return static_cast<SampleType>(found - kOwnTypes.begin());
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

// The colours of `pixels`, as VolumeView has them, and samples of 8 bits: alpha if there are four channels, else luma.
void take_colours(std::span<const std::byte> pixels, std::size_t channels, bool narrow, Volume& volume) {
  const std::size_t count = pixels.size() / (channels * (narrow ? 1 : 2));
  const auto byte_at = [&](std::size_t i) {  // the nearest of 8 bits
    if (narrow) return static_cast<int>(sample_at<std::uint8_t>(pixels, i));
    return (sample_at<std::uint16_t>(pixels, i) * 255 + 32767) / 65535;
  };
  volume.samples.resize(count);
  volume.colours.resize(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const int red = byte_at(channels * i), green = byte_at(channels * i + 1), blue = byte_at(channels * i + 2);
    const int luma = (2126 * red + 7152 * green + 722 * blue + 5000) / 10000;  // [ITU-R BT.709]
    volume.colours[3 * i] = static_cast<std::uint8_t>(red);
    volume.colours[3 * i + 1] = static_cast<std::uint8_t>(green);
    volume.colours[3 * i + 2] = static_cast<std::uint8_t>(blue);
    volume.samples[i] = static_cast<std::byte>(channels == 4 ? byte_at(channels * i + 3) : luma);
  }
}

}  // namespace

StoredType stored_type(SampleType type) { return kOwnTypes.at(static_cast<std::size_t>(type)); }

Dims checked_dims(const std::filesystem::path& file, const std::string& field, std::span<const std::int64_t> sizes) {
  const std::string got = fmt::format("{}", fmt::join(sizes, " x "));
  if (sizes.size() < 3) throw FileError(file, field, "three axes", sizes.empty() ? "none" : got);
  Dims dims{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (sizes[axis] < 1 || sizes[axis] > kMaxFileDim)
      throw FileError(file, field, fmt::format("three axes of 1..{} voxels", kMaxFileDim), got);
    dims[axis] = static_cast<int>(sizes[axis]);
  }
  return dims;
}

std::int64_t volumes_in(const std::filesystem::path& file, const std::string& field,
                        std::span<const std::int64_t> sizes) {
  std::int64_t count = 1;
  for (const std::int64_t size : sizes.subspan(3)) {
    if (size < 1 || size > kMaxParts)
      throw FileError(file, field, fmt::format("1..{} volumes", kMaxParts), fmt::format("{}", size));
    count = std::min(count * size, std::int64_t{kMaxParts} + 1);
  }
  return count;
}

std::size_t chosen_part(const std::filesystem::path& file, const std::string& what, std::int64_t count,
                        const std::string& part) {
  if (count > kMaxParts) throw FileError(file, what, fmt::format("at most {}", kMaxParts), "more");
  if (part.empty()) {
    if (count > 1) warn(file, what, fmt::format("a part, 1..{}", count), "none; 1 is taken");
    return 0;
  }
  const auto number = parse_number<std::int64_t>(part);
  if (!number || *number < 1 || *number > count)
    throw FileError(file, "part", fmt::format("a {}, 1..{}", what, count), in_quotes(part));
  return static_cast<std::size_t>(*number - 1);
}

bool is_kept(const StoredLayout& layout) { return layout.channels == 1 && kept_type(layout).has_value(); }

void to_machine(std::span<std::byte> samples, const StoredLayout& layout) {
  const std::size_t size = bytes_of(layout.type);
  const bool swapped = size > 1 && layout.big_endian != (std::endian::native == std::endian::big);
  for (std::size_t i = 0; swapped && i < samples.size(); i += size) std::ranges::reverse(samples.subspan(i, size));
  for (std::size_t i = 0; layout.type == StoredType::kUint12 && i < samples.size() / size; ++i) {
    const auto sample = sample_at<std::uint16_t>(samples, i);
    if (sample > 4095)
      throw FileError(layout.file, fmt::format("sample {}", layout.first_sample + i), "0..4095",
                      fmt::format("{}", sample));
  }
}

std::size_t checked_bytes(const StoredLayout& layout) {
  // At most 2^36 voxels of 8 bytes: no overflow.
  const std::uint64_t count = voxels_of(layout.dims) * static_cast<std::uint64_t>(layout.channels);
  const std::size_t kept = kept_type(layout) ? bytes_of(layout.type) : sizeof(float);
  const std::uint64_t bytes = count * std::max(kept, bytes_of(layout.type));
  if (bytes > kMaxVolumeBytes) {
    throw FileError(layout.file, "size", fmt::format("at most {} bytes of samples", kMaxVolumeBytes),
                    fmt::format("{} ({}{})", bytes, fmt::join(layout.dims, " x "),
                                layout.channels > 1 ? fmt::format(" x {}", layout.channels) : ""));
  }
  return count * bytes_of(layout.type);
}

Volume to_volume(std::vector<std::byte> stored, const StoredLayout& layout) {
  Volume volume;
  volume.dims = layout.dims;
  volume.source = layout.file.string();
  volume.spacing = layout.spacing;
  volume.placement = layout.placement;
  to_machine(stored, layout);
  if (layout.channels > 1) {
    const auto channels = static_cast<std::size_t>(layout.channels);
    if (layout.channel < 0) {
      const bool narrow = layout.type == StoredType::kUint8;
      if ((!narrow && layout.type != StoredType::kUint16) || channels < 3 || channels > 4) {
        throw FileError(layout.file, "colours", "three or four channels of 8 or 16 bits",
                        fmt::format("{}, or another type", channels));
      }
      take_colours(stored, channels, narrow, volume);
      return volume;
    }
    const std::size_t bytes = bytes_of(layout.type), count = stored.size() / (bytes * channels);
    for (std::size_t i = 0; i < count; ++i) {
      std::memmove(stored.data() + i * bytes,
                   stored.data() + (i * channels + static_cast<std::size_t>(layout.channel)) * bytes, bytes);
    }
    stored.resize(count * bytes);
  }
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

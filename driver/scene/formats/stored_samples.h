// Samples as a file stores them, and their conversion to a Volume, for the readers of all formats.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/scene/volume_file.h"

namespace gicube::scene {

enum class StoredType { kInt8, kUint8, kUint12, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat32, kFloat64 };

// The type of this name: int8, uint8, int16 ... float64. Nothing: there is none.
inline std::optional<StoredType> type_named(std::string_view name) {
  constexpr std::array<std::string_view, 11> kNames{"int8",   "uint8", "",       "int16",   "uint16", "int32",
                                                    "uint32", "int64", "uint64", "float32", "float64"};  // in its order
  const auto* const found = std::ranges::find(kNames, name);
  return name.empty() || found == kNames.end() ? std::nullopt
                                               : std::optional(static_cast<StoredType>(found - kNames.begin()));
}

// Calls `use` with a number of the C++ type of these samples.
template <typename Use>
auto with_sample(StoredType type, const Use& use) {
  switch (type) {
    case StoredType::kInt8: return use(std::int8_t{});
    case StoredType::kUint8: return use(std::uint8_t{});
    case StoredType::kInt16: return use(std::int16_t{});
    case StoredType::kUint12:
    case StoredType::kUint16: break;
    case StoredType::kInt32: return use(std::int32_t{});
    case StoredType::kUint32: return use(std::uint32_t{});
    case StoredType::kInt64: return use(std::int64_t{});
    case StoredType::kUint64: return use(std::uint64_t{});
    case StoredType::kFloat32: return use(float{});
    case StoredType::kFloat64: return use(double{});
  }
  return use(std::uint16_t{});
}

StoredType stored_type(SampleType type);
template <typename Use>
auto with_sample(SampleType type, const Use& use) {
  return with_sample(stored_type(type), use);
}

// The sample at this index, in the machine's byte order.
template <typename Sample>
Sample sample_at(std::span<const std::byte> bytes, std::size_t index) {
  Sample sample;
  std::memcpy(&sample, &bytes[index * sizeof sample], sizeof sample);
  return sample;
}

inline std::size_t bytes_of(StoredType type) {
  return with_sample(type, [](auto sample) { return sizeof sample; });
}

struct StoredLayout {
  std::filesystem::path file;  // named in errors
  Dims dims{};
  StoredType type = StoredType::kUint8;
  Vec3 spacing{1, 1, 1};  // of any sign and value
  bool big_endian = false;
  double slope = 1;  // value = slope * stored + intercept
  double intercept = 0;
  int channels = 1;              // samples per voxel, side by side
  int channel = -1;              // the one to read, from 0; -1: they are red, green, blue and, if there are four, alpha
  WorldPlacement placement{};    // of the stored axes; directions may have any length but 0
  std::size_t first_sample = 0;  // of a part: the number of its first sample, for errors
};

// The first three of a file's axis sizes, each of which must be 1..kMaxFileDim. Throws FileError naming `field`.
Dims checked_dims(const std::filesystem::path& file, const std::string& field, std::span<const std::int64_t> sizes);

constexpr int kMaxParts = 1 << 20;  // chosen: volumes in a file

// The number of volumes along the axes behind the third, at most kMaxParts + 1. Throws FileError naming `field`.
std::int64_t volumes_in(const std::filesystem::path& file, const std::string& field,
                        std::span<const std::int64_t> sizes);

// The index of the one among `count` volumes (or channels; `what`) that `part` names by its number, from 1. Warns which
// one is taken if there are several and `part` is empty. Throws FileError.
std::size_t chosen_part(const std::filesystem::path& file, const std::string& what, std::int64_t count,
                        const std::string& part);

// The number of bytes that the layout's samples take in the file. Throws FileError above kMaxVolumeBytes, stored or
// converted.
std::size_t checked_bytes(const StoredLayout& layout);
// Whether the driver takes the samples as they are stored, except for the byte order; others become floats or colours.
bool is_kept(const StoredLayout& layout);

// Brings stored samples into the machine's byte order. Throws FileError when a 12-bit sample is above 4095.
void to_machine(std::span<std::byte> samples, const StoredLayout& layout);

// Converts the bytes, exactly checked_bytes(layout), into a type that the driver takes, in the machine's byte order.
// Throws FileError as to_machine() does, and when a converted sample is not a finite 32-bit float.
Volume to_volume(std::vector<std::byte> stored, const StoredLayout& layout);

// Samples stored as text.

// Reads `count` numbers, separated by white space or commas, from byte `offset` on, as samples in the machine's byte
// order. Throws FileError: too few numbers, other text, or a number out of the type's range.
std::vector<std::byte> read_numbers(const std::filesystem::path& file, std::uint64_t offset, StoredType type,
                                    std::size_t count);

// Reads `bytes` bytes of two hexadecimal digits each, with white space anywhere. Throws FileError: too few digits, or
// another character.
std::vector<std::byte> read_hex(const std::filesystem::path& file, std::uint64_t offset, std::size_t bytes);

}  // namespace gicube::scene

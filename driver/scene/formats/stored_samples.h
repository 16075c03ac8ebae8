// The samples of a file as they are stored, and their way into a Volume. Shared by the readers of all formats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "gicube/scene/volume_file.h"

namespace gicube::scene {

enum class StoredType { kInt8, kUint8, kUint12, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat32, kFloat64 };

// Calls `use` with a number of the type in which such samples are stored.
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

// The sample of that index, in the machine's byte order.
template <typename Sample>
Sample sample_at(std::span<const std::byte> bytes, std::size_t index) {
  Sample sample;
  std::memcpy(&sample, &bytes[index * sizeof sample], sizeof sample);
  return sample;
}

std::size_t bytes_of(StoredType type);

struct StoredLayout {
  std::filesystem::path file;  // named in errors
  Dims dims{};
  StoredType type = StoredType::kUint8;
  Vec3 spacing{1, 1, 1};  // of any sign and value
  bool big_endian = false;
  double slope = 1;  // value = slope * stored + intercept
  double intercept = 0;
  int channels = 1;              // samples of a voxel, side by side
  int channel = -1;              // which of them, from 0; -1: the channels are red, green, blue and, of four, alpha
  WorldPlacement placement{};    // of the axes as they are stored; directions of any length but 0
  std::size_t first_sample = 0;  // of a part: the number of its first, as errors name it
};

// The first three of a file's axis sizes; there must be at least three, each 1..kMaxFileDim, and those beyond must
// be 1. Throws FileError naming `field`.
Dims checked_dims(const std::filesystem::path& file, const std::string& field, std::span<const std::int64_t> sizes);

constexpr int kMaxParts = 1 << 20;  // chosen: volumes in a file

// The index of the one of `count` volumes (or channels; `what`) that `part` says, from 1 on. Says which is taken if
// there are several and `part` is empty. Throws FileError.
std::size_t chosen_part(const std::filesystem::path& file, const std::string& what, std::int64_t count,
                        const std::string& part);

// The colours of `pixels`, of 8 or 16 bits, as VolumeView has them, and the samples beside them, of 8 bits: alpha if
// there are four channels, else luma.
void take_colours(std::span<const std::byte> pixels, std::size_t channels, SampleType type,
                  std::vector<std::byte>& samples, std::vector<std::uint8_t>& colours);

// How many bytes the layout's samples take in the file. Throws FileError above kMaxVolumeBytes, stored or converted.
std::size_t checked_bytes(const StoredLayout& layout);
// The driver takes the samples as they are stored, but for the order of bytes; others become floats.
bool is_kept(const StoredLayout& layout);

// Brings the bytes, exactly checked_bytes(layout), into the machine's order and a type that the driver takes.
// Throws FileError when a 12-bit sample is above 4095, or a converted one is not a finite 32-bit float.
Volume to_volume(std::vector<std::byte> stored, const StoredLayout& layout);

// Samples that a file holds as text.

// `count` numbers parted by white space or commas, from byte `offset` on, as samples in the machine's byte order.
// Throws FileError: too few, no number, or out of the type's range.
std::vector<std::byte> read_numbers(const std::filesystem::path& file, std::uint64_t offset, StoredType type,
                                    std::size_t count);

// `bytes` bytes of two hexadecimal digits each, white space allowed anywhere; the bytes as they stand.
// Throws FileError: too few, or another character.
std::vector<std::byte> read_hex(const std::filesystem::path& file, std::uint64_t offset, std::size_t bytes);

}  // namespace gicube::scene

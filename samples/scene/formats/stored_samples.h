// The samples of a file as they are stored, and their way into a Volume. Shared by the readers of all formats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "scene/formats/volume_file.h"

namespace gicube::samples {

enum class StoredType { kInt8, kUint8, kUint12, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat32, kFloat64 };

std::size_t bytes_of(StoredType type);
StoredType stored_type(SampleType type);

struct StoredLayout {
  std::filesystem::path file;  // named in errors
  Dims dims{};
  StoredType type = StoredType::kUint8;
  Vec3 spacing{1, 1, 1};  // of any sign and value
  bool big_endian = false;
  double slope = 1;  // value = slope * stored + intercept
  double intercept = 0;
};

// The first three of a file's axis sizes; there must be at least three, each 1..kMaxFileDim, and those beyond must
// be 1. Throws FileError naming `field`.
Dims checked_dims(const std::filesystem::path& file, const std::string& field, std::span<const std::int64_t> sizes);

// How many bytes the layout's samples take in the file. Throws FileError above kMaxVolumeBytes, stored or converted.
std::size_t checked_bytes(const StoredLayout& layout);

// Brings the bytes, exactly checked_bytes(layout), into the machine's order and a type that the driver takes.
// Throws FileError when a 12-bit sample is above 4095, or a converted one is not a finite 32-bit float.
Volume to_volume(std::vector<std::byte> stored, const StoredLayout& layout);

}  // namespace gicube::samples

// Small files for the tests of the readers, and what to expect of them.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "gicube/scene/volume_file.h"
#include "temporary_directory.h"

namespace gicube::scene {

struct TemporaryFolder : reference::TemporaryDirectory {
  std::filesystem::path path() const { return TemporaryDirectory::path(); }
};

enum class Order { kLittle, kBig };

// The samples' bytes in the given order.
template <typename Sample>
std::string stored(const std::vector<Sample>& samples, Order order = Order::kLittle) {
  std::string bytes;
  for (const Sample sample : samples) {
    char one[sizeof(Sample)];
    std::memcpy(one, &sample, sizeof(Sample));
    if ((order == Order::kBig) != (std::endian::native == std::endian::big)) std::reverse(one, one + sizeof(Sample));
    bytes.append(one, sizeof(Sample));
  }
  return bytes;
}

// 2 x 3 x 4 different samples, no byte pattern a palindrome.
template <typename Sample>
std::vector<Sample> ramp() {
  std::vector<Sample> samples;
  for (int i = 0; i < 24; ++i) samples.push_back(static_cast<Sample>(1 + i * (sizeof(Sample) == 1 ? 5 : 157)));
  return samples;
}
constexpr Dims kRampDims{2, 3, 4};

// The samples of a volume that is read in planes: in one part, or in several.
inline std::vector<std::byte> bytes_in_planes(const Volume& volume, int planes) {
  const std::size_t bytes = voxels_of({volume.dims[0], volume.dims[1], 1}) * bytes_per_sample(volume.type);
  std::vector<std::byte> out(bytes * static_cast<std::size_t>(volume.dims[2]));
  for (int z = 0; z < volume.dims[2]; z += planes) {
    const int count = std::min(planes, volume.dims[2] - z);
    volume.planes(z, count,
                  std::span(out).subspan(bytes * static_cast<std::size_t>(z), bytes * static_cast<std::size_t>(count)));
  }
  return out;
}

template <typename Sample>
std::vector<Sample> samples_of(const Volume& volume) {
  std::vector<Sample> samples(volume.samples.size() / sizeof(Sample));
  std::memcpy(samples.data(), volume.samples.data(), volume.samples.size());
  return samples;
}

template <typename To, typename From>
std::vector<To> as(const std::vector<From>& from) {
  return std::vector<To>(from.begin(), from.end());
}

std::string gzip(const std::string& bytes);
std::string zlib(const std::string& bytes);

// Collects the warnings of gicube-scene.
class Warnings {
 public:
  Warnings() {
    set_warning_handler([this](const std::string& text) { texts.push_back(text); });
  }
  ~Warnings() { set_warning_handler({}); }
  Warnings(const Warnings&) = delete;
  Warnings& operator=(const Warnings&) = delete;

  std::vector<std::string> texts{};
};

// The text of the FileError that reading the file throws; "none" if it throws none.
std::string read_error(const std::filesystem::path& path, const std::optional<RawLayout>& layout = std::nullopt);

}  // namespace gicube::scene

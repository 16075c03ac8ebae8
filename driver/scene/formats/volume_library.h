// Readers of volumes in separate shared objects (driver/scene/libraries): DICOM, HDF5, OpenVDB. Errors are returned,
// not thrown, across their boundary.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gicube/scene/volume_file.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {

// Arguments of FileError and warn().
struct FileFault {
  std::filesystem::path file;
  std::string field, expected, got;
};

struct LibraryVolume {
  StoredLayout layout;  // of `samples`, in the machine's byte order
  std::vector<std::byte> samples;
  std::vector<FileFault> warnings;
  std::optional<FileFault> fault;  // if set, only the warnings are valid besides
};

class VolumeLibrary {
 public:
  virtual ~VolumeLibrary() = default;
  // `part`: VolumeSource::part.
  virtual LibraryVolume read(const std::filesystem::path& file, const std::string& part) const = 0;
  // Nothing: success.
  virtual std::optional<FileFault> write(const FloatVolume& volume, const std::filesystem::path& file) const = 0;
};

// The number of bytes of the layout's samples; nothing if its sizes are invalid or exceed kMaxVolumeBytes.
inline std::optional<std::size_t> sane_bytes(const StoredLayout& layout, std::size_t sample_bytes) {
  std::uint64_t bytes = sample_bytes * static_cast<std::uint64_t>(layout.channels);
  for (const int dim : layout.dims) {
    if (dim < 1 || dim > kMaxFileDim) return std::nullopt;
    bytes *= static_cast<std::uint64_t>(dim);
  }
  return bytes <= kMaxVolumeBytes ? std::optional<std::size_t>(bytes) : std::nullopt;
}

// Limits of a reading child's processor time (reading_child.h): kReadingSeconds until the size of the volume is known;
// allow_time_for(), which a reader calls before it fills the samples, adds a second per kBytesASecond. Damaged files
// make libraries search for seconds before they give up.
constexpr std::uint64_t kReadingSeconds = 2, kBytesASecond = std::uint64_t{4} << 20;  // chosen: far beyond good files
inline void allow_time_for(std::uint64_t bytes) {
  rlimit now{};
  if (::getrlimit(RLIMIT_CPU, &now) != 0 || now.rlim_cur == RLIM_INFINITY) return;  // no such child
  now.rlim_cur = std::min<rlim_t>(now.rlim_cur + bytes / kBytesASecond, now.rlim_max);
  ::setrlimit(RLIMIT_CPU, &now);
}

bool is_dicom(const std::filesystem::path& path);  // a file, or a folder that has more of them than pictures
bool is_hdf5(const std::filesystem::path& file);
bool is_openvdb(const std::filesystem::path& file);

// Reading and writing by the shared object of this name: dicom, hdf5 or openvdb. Throw FileError.
Volume read_by(const std::string& library, const std::filesystem::path& file, const std::string& part);
void write_by(const std::string& library, const FloatVolume& volume, const std::filesystem::path& file);

}  // namespace gicube::scene

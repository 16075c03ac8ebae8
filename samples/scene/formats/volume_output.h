// Volumes of floats into files that other programs read.
#pragma once

#include <filesystem>
#include <span>

#include "gicube/vector.h"
#include "scene/formats/file_error.h"

namespace gicube::samples {

struct FloatVolume {
  Dims dims{};
  Vec3 spacing{1, 1, 1};          // voxel edges, > 0
  Vec3 origin;                    // of the first voxel's centre; axes run along x, y, z
  std::span<const float> values;  // x fastest
  int channels = 1;               // or 3, a voxel's side by side: write_compressed_nrrd() only
};

// Whether write_volume() knows the extension.
bool is_volume_output(const std::filesystem::path& path);
// By the extension: .nrrd, .mhd (samples in a .raw beside it), .mha, .nii, .nii.gz. Values, spacing and origin come back
// as they are, in NIfTI spacing and origin as 32-bit floats. A file that was there stays until the new one is whole.
// Throws FileError: another extension, a wrong number of values, a place that can't be written to.
void write_volume(const FloatVolume& volume, const std::filesystem::path& path);

// As NRRD, compressed, without an origin. Throws FileError.
void write_compressed_nrrd(const FloatVolume& volume, const std::filesystem::path& path);

}  // namespace gicube::samples

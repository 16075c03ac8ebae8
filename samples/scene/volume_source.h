// Where a volume comes from.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "scene/formats/volume_file.h"

namespace gicube::samples {

struct VolumeSource {
  std::string builtin;           // "buckyball", or empty
  std::filesystem::path file;    // a file or a folder of slices
  int size = 256;                // voxels an edge, builtin only
  std::optional<RawLayout> raw;  // headerless files only
  std::optional<Vec3> spacing;   // overrides the file's

  friend bool operator==(const VolumeSource&, const VolumeSource&) = default;
};

}  // namespace gicube::samples

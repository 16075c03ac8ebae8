// A volume file whose samples are found, and how they are read: whole, or in planes.
#pragma once

#include "gicube/scene/volume_file.h"
#include "scene/formats/data_stream.h"
#include "scene/formats/stored_samples.h"

namespace gicube::scene {

enum class Encoding { kBytes, kNumbers, kHex };  // the last two are text

struct StoredFile {
  StoredLayout layout;
  DataPlace place;
  Encoding encoding = Encoding::kBytes;
};

// Throws FileError.
Volume read_stored(const StoredFile& file);
// Opens the file without its samples: Volume::planes reads them. Text is read whole. Throws FileError, as does the
// reader.
Volume open_stored(const StoredFile& file);

// Reads all planes of a volume into memory.
void take_planes(Volume& volume);

// Calls use(z, samples) for each plane of a volume, read or in memory.
void for_each_plane(const Volume& volume, const std::function<void(int, std::span<const std::byte>)>& use);

}  // namespace gicube::scene

// Reading a volume file whose layout is known: whole, or in planes.
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

// Opens the file without its samples, which Volume::planes then reads. Samples in text, of several channels, or in
// several files are read at once. Throws FileError, as Volume::planes does.
Volume open_stored(const StoredFile& file);
// Reads the whole file. Throws FileError.
Volume read_stored(const StoredFile& file);

// Reads the planes of a volume that has them into memory.
void take_planes(Volume& volume);

// Calls use(z, samples) for each plane of a volume, which may be in memory or in planes.
void for_each_plane(const Volume& volume, const std::function<void(int, std::span<const std::byte>)>& use);

}  // namespace gicube::scene

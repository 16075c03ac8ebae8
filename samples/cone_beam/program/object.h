// What is projected or compared with: a phantom, or a volume from a file.
#pragma once

#include <filesystem>
#include <vector>

#include "cone_beam/phantom/phantom.h"
#include "cone_beam/program/options.h"

namespace gicube::samples {

bool is_phantom(const ObjectOptions& object);
// Throws InputError if there is none of this name.
Phantom phantom_of(const ObjectOptions& object);

struct GridValues {
  Grid grid;
  std::vector<float> values;
};
// Throws FileError: what read_volume() throws, a value that is not finite.
GridValues read_values(const std::filesystem::path& file);

// The origin of a volume that is centred on `centre`: its first voxel's place.
Vec3 origin_of(const Grid& grid, Vec3 centre);

}  // namespace gicube::samples

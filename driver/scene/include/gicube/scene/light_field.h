// Light that falls on the voxels of a volume: a file of its own, and pictures of it.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "gicube/board.h"
#include "gicube/export.h"
#include "gicube/scene/image_file.h"
#include "gicube/scene/provenance.h"
#include "gicube/transfer_function.h"

namespace gicube::scene {

// Power that falls on a unit of area, or a quarter of the fluence in a medium: a diffuse surface there, or a
// medium that scatters evenly, shows its colour times this.
struct LightField {
  Dims dims{};
  int channels = 1;           // or 3: red, green, blue
  std::vector<float> values;  // x fastest, a voxel's channels side by side; 0 or more
};

// NRRD of float, compressed: axes x, y, z or, with three channels, 3, x, y, z. `spacing`, the voxels' edges, and
// `origin`, the first voxel's centre, are noted in the file. Throws FileError; a file that was there stays until the
// new one is whole.
GICUBE_API void write_light_field(const LightField& field, Vec3 spacing, Vec3 origin, const std::filesystem::path& path,
                                  const Provenance& provenance = {});
// Throws FileError: no such file, another type than float, other axes, a value that is below 0 or not finite.
GICUBE_API LightField read_light_field(const std::filesystem::path& path);

// Takes one channel (0 red, 1 green, 2 blue) of a picture. What is seen through may have another alpha in each: a
// background is blended in here, and the result is opaque; without one alpha is the greatest of all channels.
GICUBE_API void take_channel(const Image& from, int channel, const std::optional<Background>& background, Image& into);

// Brightness of a unit of it that shows the lighter parts well: nine in ten values above 0 are below 0.8 of white [C];
// 1 for a field without light.
GICUBE_API double exposure_for(const LightField& field);

// A picture of the volume on the board, which has the field's size, in that light: one rendering, or, on a board of one
// irradiance word, one a channel whose channels are put together. Opaque over a background; without one alpha is the
// volume's. What shows brighter than four times white under `exposure` is clipped [C], so that the paper's 11 bits of
// irradiance are left for the rest.
GICUBE_API Image picture_of(Board& board, const LightField& field, View view, double exposure,
                            const std::optional<Background>& background, const Progress& progress = {});

}  // namespace gicube::scene

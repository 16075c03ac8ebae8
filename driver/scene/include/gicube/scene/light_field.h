// Light that falls on the voxels of a volume: its files and its pictures.
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

// Power per unit of area that falls on a surface, or a quarter of the fluence in a medium. A diffuse surface, or a
// medium that scatters isotropically, shows its colour times this.
struct LightField {
  Dims dims{};
  int channels = 1;           // or 3: red, green, blue
  std::vector<float> values;  // x fastest, a voxel's channels side by side; 0 or more
};

// Compressed NRRD of floats with the axes x, y, z or, with three channels, 3, x, y, z. The file records `spacing`, the
// voxels' edges, and `origin`, the first voxel's centre. Throws FileError; an existing file stays until the new one is
// complete.
GICUBE_API void write_light_field(const LightField& field, Vec3 spacing, Vec3 origin, const std::filesystem::path& path,
                                  const Provenance& provenance = {});
// Throws FileError: no such file, another type than float, other axes, a value below 0 or not finite.
GICUBE_API LightField read_light_field(const std::filesystem::path& path);

// Copies one channel (0 red, 1 green, 2 blue) of a picture. Translucent pixels may have another alpha in each channel:
// with a background, it is blended in here and the result is opaque; without one, alpha is the greatest of all
// channels.
GICUBE_API void take_channel(const Image& from, int channel, const std::optional<Background>& background, Image& into);

// The exposure that shows the brighter parts well: nine in ten of the values above 0 stay below 0.8 of white [C]. 1 for
// a field without light.
GICUBE_API double exposure_for(const LightField& field);

// A picture of the volume on the board, which has the field's size, in that light: one rendering, or one for each
// channel on a board with one irradiance word. Opaque over a background; without one, alpha is the volume's. Light
// brighter than four times white under `exposure` is clipped [C], so that the paper's 11 bits of irradiance remain for
// the rest.
GICUBE_API Image picture_of(Board& board, const LightField& field, View view, double exposure,
                            const std::optional<Background>& background, const Progress& progress = {});

}  // namespace gicube::scene

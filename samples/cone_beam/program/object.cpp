#include "cone_beam/program/object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/formats/volume_file.h"
#include "scene/program/input_error.h"

namespace gicube::samples {

bool is_phantom(const ObjectOptions& object) { return object.name.starts_with("builtin:"); }

Phantom phantom_of(const ObjectOptions& object) {
  const auto times_value = [&object](Phantom phantom) {
    for (Ellipsoid& ellipsoid : phantom) ellipsoid.value *= object.value;
    return phantom;
  };
  if (object.name == "builtin:shepp-logan") return times_value(shepp_logan(object.radius));
  if (object.name == "builtin:shepp-logan-high-contrast") return times_value(high_contrast_shepp_logan(object.radius));
  if (object.name == "builtin:sphere") return uniform_sphere(object.radius, object.value);
  throw InputError("phantom", "builtin:shepp-logan, builtin:shepp-logan-high-contrast or builtin:sphere",
                   in_quotes(object.name));
}

GridValues read_values(const std::filesystem::path& file) {
  const Volume volume = read_volume(file);
  GridValues out{{volume.dims, volume.spacing}, values_of(volume)};
  const auto bad = std::ranges::find_if(out.values, [](float value) { return !std::isfinite(value); });
  if (bad != out.values.end()) {
    throw FileError(file, fmt::format("voxel {}", bad - out.values.begin()), "a finite value", fmt::format("{}", *bad));
  }
  return out;
}

Vec3 origin_of(const Grid& grid, Vec3 centre) { return centre + to_space(grid, {0, 0, 0}); }

}  // namespace gicube::samples

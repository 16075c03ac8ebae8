#include "scene/hashes.h"

#include <span>
#include <type_traits>
#include <variant>
#include <vector>

#include "gicube/scene/provenance.h"

#include "scene/formats/plane_file.h"

namespace gicube::scene {
namespace {

// Hashes numbers one after the other, not whole records, whose padding is undefined.
struct Hasher {
  std::uint64_t hash = 0;

  template <typename Number>
  void add_all(std::span<const Number> numbers) {
    static_assert(std::is_arithmetic_v<Number> || std::is_same_v<Number, std::byte>);
    hash = hash_of(std::as_bytes(numbers), hash);
  }
  template <typename... Numbers>
  void add(Numbers... numbers) {
    for (const double number : {static_cast<double>(numbers)...}) add_all(std::span(&number, 1));
  }
  void add(Vec3 v) { add(v.x, v.y, v.z); }
  void add(const Colour& colour) { add(colour[0], colour[1], colour[2]); }

  void add(const TransferFunctionFile& file) {
    add(static_cast<int>(file.scale), file.function.colours.size(), file.function.opacities.size());
    for (const ColourPoint& point : file.function.colours) add(point.value), add(point.colour);
    for (const OpacityPoint& point : file.function.opacities) add(point.value, point.opacity);
  }
  void add(const Material& optics) {
    add(optics.scattering, static_cast<int>(optics.bsdf), optics.gloss, optics.seen_through_scattering, optics.routine,
        optics.surface, optics.parameters.size());
    add_all(std::span<const float>(optics.parameters));
  }
  void add(const PointLight& light) { add(light.position), add(light.power); }
  void add(const DirectionalLight& light) { add(light.towards), add(light.irradiance); }
  void add(const RectangleLight& light) { add(light.corner), add(light.edge_u), add(light.edge_v), add(light.power); }
  void add(const SphereLight& light) { add(light.centre), add(light.radius, light.power); }
};

}  // namespace

std::uint64_t hash_of_voxels(const SceneSetup& setup) {
  Hasher hasher;
  const Volume& volume = setup.volume;
  hasher.add(volume.dims[0], volume.dims[1], volume.dims[2], static_cast<int>(volume.type));
  hasher.add(volume.spacing);
  std::vector<std::byte> colours(volume.colour_planes ? 3 * voxels_of({volume.dims[0], volume.dims[1], 1}) : 0);
  for_each_plane(volume, [&](int z, std::span<const std::byte> samples) {
    hasher.add_all(samples);
    if (volume.colour_planes) volume.colour_planes(z, 1, colours);
    hasher.add_all(std::span<const std::byte>(colours));
  });
  hasher.add_all(std::span<const std::uint8_t>(volume.colours));
  hasher.add_all(std::span<const std::uint8_t>(setup.tags));
  hasher.add_all(std::span<const float>(setup.gradients));
  return hasher.hash;
}

std::uint64_t scene_hash(const SceneSetup& setup) {
  Hasher hasher{setup.voxel_hash};
  for (const TransferFunctionFile& look : setup.materials) hasher.add(look);
  for (std::size_t tag = 0; tag < setup.optics.size(); ++tag) {
    hasher.add(setup.optics[tag]);
    hasher.add(setup.scattering_colours[tag]);
    hasher.add(setup.emissions[tag]);
  }
  for (std::size_t i = 0; i < setup.lights.size(); ++i) {
    hasher.add(setup.lights[i].index());
    std::visit([&hasher](const auto& light) { hasher.add(light); }, setup.lights[i]);
    hasher.add(setup.light_colours[i]);
  }
  const Phong& phong = setup.shading.phong;
  hasher.add(setup.shading.light);
  hasher.add(phong.ambient, phong.diffuse, phong.specular, phong.shininess, setup.lighting.on);
  return hasher.hash;
}

}  // namespace gicube::scene

#include "compose/composition.h"

#include <fmt/format.h>

#include <cmath>

#include "gicube/v1/composition.pb.h"
#include "scene/common/faults.h"
#include "scene/common/whole_file.h"
#include "scene/graph/graph_reader.h"
#include "scene/program/scene_input.h"

namespace gicube::samples {
namespace {

constexpr int kMaxNesting = 20;  // chosen: of braces; bounds the parser's stack

// Converts the parsed message to a composition; an error leaves that part of it at its default.
struct Translator {
  Faults& faults;
  NamedFiles files;

  Composition translate(const v1::Composition& source) {
    Composition out;
    const int parts = source.volume_size() + source.surface_size() + source.shell_size();
    faults.check(parts > 0, "volume", "at least one volume, surface or shell", "none");
    for (int i = 0; i < source.volume_size(); ++i) {
      out.volumes.push_back(volume(fmt::format("volume[{}]", i), source.volume(i)));
    }
    for (int i = 0; i < source.surface_size(); ++i) {
      out.surfaces.push_back(surface(fmt::format("surface[{}]", i), source.surface(i)));
    }
    for (int i = 0; i < source.shell_size(); ++i) {
      out.shells.push_back(shell(fmt::format("shell[{}]", i), source.shell(i)));
    }
    if (source.has_camera()) out.camera = read_camera(faults, "camera", source.camera());
    if (source.has_phong()) out.phong = read_phong(faults, source.phong());
    if (source.has_light()) out.light = read_direction(faults, "light", source.light());
    if (source.has_background()) out.background = read_colour(faults, "background", source.background());
    read_image(faults, source.image(), out.view);
    out.view.step = faults.check_range("step", source.step(), 1.0 / 64, 16);
    out.overlap_step = faults.check_range("overlap_step", source.overlap_step(), 1.0 / 64, 4096);
    out.view.opacity_threshold = faults.check_range("opacity_threshold", source.opacity_threshold(), 1e-6, 1);
    return out;
  }

  template <typename Part>
  Affine placement(const std::string& field, const Part& source) {
    std::vector<Transform> transforms;
    for (int i = 0; i < source.transform_size(); ++i) {
      transforms.push_back(read_transform(faults, fmt::format("{}.transform[{}]", field, i), source.transform(i)));
    }
    Affine map;
    faults.gather_part(field, [&] { map = map_of(transforms); });
    return map;
  }

  PlacedVolume volume(const std::string& field, const v1::PlacedVolume& source) {
    PlacedVolume out;
    out.name = source.name().empty() ? field : source.name();
    out.to_space = placement(field, source);
    faults.gather_part(field, [&] { out.scene = scene(source); });
    return out;
  }

  // Reads a volume or shell. Exceptions name the field.
  template <typename Part>
  Scene scene(const Part& source) const {
    const std::string& input = source.input();
    if (input.empty()) throw InputError("input", "a scene, a volume file or builtin:buckyball", "none");
    const std::string named = input.starts_with(kBuiltin) ? input : files.file("input", input).string();
    Scene scene = at_time(read_input(named, files.allow_outside), 0);
    if (source.has_volume_size()) {
      if (!scene.world && scene.volume.builtin.empty()) {
        throw InputError("volume_size", "none for a volume file, which has its own", shown(source.volume_size()));
      }
      if (source.volume_size() < kMinWorldSize || source.volume_size() > kMaxWorldSize) {
        throw InputError("volume_size", fmt::format("{} to {} voxels", kMinWorldSize, kMaxWorldSize),
                         shown(source.volume_size()));
      }
      (scene.world ? scene.world->size : scene.volume.size) = static_cast<int>(source.volume_size());
    }
    if (const std::string& name = source.transfer_function(); !name.empty()) {
      const bool preset = std::ranges::any_of(presets(), [&](const Preset& each) { return each.name == name; });
      scene.transfer_function =
          preset ? find_preset(name) : read_transfer_function(files.file("transfer_function", name));
    }
    // The composition has the light.
    scene.lighting.on = false;
    return scene;
  }

  PlacedSurface surface(const std::string& field, const v1::Surface& source) {
    PlacedSurface out;
    out.name = source.name().empty() ? field : source.name();
    if (source.has_colour()) out.colour = read_colour(faults, field + ".colour", source.colour());
    out.opacity = faults.check_range(field + ".opacity", source.opacity(), 0, 1);
    out.mesh = mesh(field, source);
    return out;
  }

  PlacedShell shell(const std::string& field, const v1::Shell& source) {
    constexpr int kMaxRepeat = 1000;  // chosen: a ray has a segment in each copy
    PlacedShell out;
    out.name = source.name().empty() ? field : source.name();
    faults.gather_part(field, [&] { out.scene = scene(source); });
    out.mesh = mesh(field, source);
    faults.check(source.thickness() > 0 && std::isfinite(source.thickness()), field + ".thickness", "a number above 0",
                 shown(source.thickness()));
    out.settings = {source.thickness(), faults.check_whole(field + ".repeat_u", source.repeat_u(), 1, kMaxRepeat),
                    faults.check_whole(field + ".repeat_v", source.repeat_v(), 1, kMaxRepeat)};
    return out;
  }

  // In the common space.
  template <typename Part>
  Mesh mesh(const std::string& field, const Part& source) {
    Mesh mesh;
    const Affine map = placement(field, source);
    faults.gather_part(field, [&] {
      if (source.file().empty()) throw InputError("file", "a mesh, .obj or .ply", "none");
      mesh = read_mesh(files.file("file", source.file()));
    });
    for (Vec3& point : mesh.points) point = map.point(point);
    return mesh;
  }
};

}  // namespace

Composition parse_composition(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                              bool allow_outside) {
  Faults faults(name);
  const NamedFiles files{folder, allow_outside};
  Composition out = Translator{faults, files}.translate(parsed_message<v1::Composition>(text, kMaxNesting, faults));
  faults.throw_if_any();
  return out;
}

Composition read_composition(const std::filesystem::path& path, bool allow_outside) {
  return parse_composition(read_text(path, "a composition"), path.string(), path.parent_path(), allow_outside);
}

}  // namespace gicube::samples

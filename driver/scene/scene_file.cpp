#include "gicube/scene/scene.h"

#include <fmt/format.h>

#include <cmath>

#include "gicube/v1/scene.pb.h"
#include "scene/buckyball.h"
#include "scene/common/faults.h"
#include "scene/common/whole_file.h"
#include "scene/graph/graph_reader.h"

namespace gicube::scene {
namespace {

constexpr int kMaxNesting = 100;  // chosen: of braces; bounds the parser's stack
constexpr int kMaxCutPlanes = 6;  // as View

// Converts the parsed message to a Scene. Faulty parts keep their defaults.
struct Translator {
  Faults& faults;
  NamedFiles files;

  Scene translate(const v1::Scene& source) {
    Scene scene;
    if (source.has_volume()) scene.volume = read_volume_source(faults, "volume", source.volume(), files);
    if (source.has_volume() == source.has_world()) {
      faults.fault("volume", "a volume or a world", source.has_world() ? "both" : "none");
    }
    if (source.has_transfer_function()) {
      scene.transfer_function =
          read_transfer_function_of(faults, "transfer_function", source.transfer_function(), files);
    }
    if (source.has_phong()) scene.phong = read_phong(faults, source.phong());
    if (source.camera_size() > 0) scene.camera = read_camera(faults, "camera", source.camera(0));
    for (int i = 1; i < source.camera_size(); ++i) {
      scene.more_cameras.push_back(read_camera(faults, fmt::format("camera[{}]", i), source.camera(i)));
    }
    for (int i = 0; i < source.cut_plane_size(); ++i) {
      scene.view.cut_planes.push_back(cut_plane(fmt::format("cut_plane[{}]", i), source.cut_plane(i)));
    }
    faults.check(source.cut_plane_size() <= kMaxCutPlanes, "cut_plane", "at most 6",
                 std::to_string(source.cut_plane_size()));
    read_image(faults, source.image(), scene.view);
    scene.view.step = faults.check_range("step", source.step(), 1.0 / 64, 16);
    scene.view.opacity_threshold = faults.check_range("opacity_threshold", source.opacity_threshold(), 0, 1);
    scene.view.shade = source.shade();
    scene.view.jitter = source.jitter();
    read_graph(source, files, faults, scene);
    return scene;
  }

  CutPlane cut_plane(const std::string& field, const v1::CutPlane& source) {
    const Vec3 normal = read_direction(faults, field + ".normal", source.normal());
    faults.check(std::isfinite(source.offset()), field + ".offset", "a finite number", shown(source.offset()));
    return {normal, source.offset()};
  }
};

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                  bool allow_outside) {
  Faults faults(name);
  const NamedFiles files{folder, allow_outside};
  Scene scene = Translator{faults, files}.translate(parsed_message<v1::Scene>(text, kMaxNesting, faults));
  faults.throw_if_any();
  return scene;
}

Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder) {
  return parse_scene(text, name, folder, false);
}

Scene read_scene(const std::filesystem::path& path, bool allow_outside) {
  return parse_scene(read_text(path, "a scene file"), path.string(), path.parent_path(), allow_outside);
}

Scene read_scene(const std::filesystem::path& path) { return read_scene(path, false); }

bool is_scene_path(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".scene" || extension == ".textproto" || extension == ".pbtxt" || extension == ".txt";
}

}  // namespace gicube::scene

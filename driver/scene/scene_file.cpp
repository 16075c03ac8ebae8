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

constexpr int kMaxNesting = 100;     // chosen: of braces; bounds the parser's stack
constexpr int kMaxCutPlanes = 6;     // as View
constexpr int kMaxImageSize = 4095;  // as View

// Turns the parsed message into a Scene; a fault leaves that part of the Scene at its default.
struct Translator {
  Faults& faults;
  std::filesystem::path folder;

  Scene translate(const v1::Scene& source) {
    Scene scene;
    if (source.has_volume()) scene.volume = read_volume_source(faults, "volume", source.volume(), folder);
    if (source.has_volume() == source.has_world()) {
      faults.fault("volume", "a volume or a world", source.has_world() ? "both" : "none");
    }
    if (source.has_transfer_function()) {
      scene.transfer_function =
          read_transfer_function_of(faults, "transfer_function", source.transfer_function(), folder);
    }
    if (source.has_phong()) scene.phong = phong(source.phong());
    if (source.camera_size() > 0) scene.camera = camera("camera", source.camera(0));
    for (int i = 1; i < source.camera_size(); ++i) {
      scene.more_cameras.push_back(camera(fmt::format("camera[{}]", i), source.camera(i)));
    }
    for (int i = 0; i < source.cut_plane_size(); ++i) {
      scene.view.cut_planes.push_back(cut_plane(fmt::format("cut_plane[{}]", i), source.cut_plane(i)));
    }
    faults.check(source.cut_plane_size() <= kMaxCutPlanes, "cut_plane", "at most 6",
                 std::to_string(source.cut_plane_size()));
    image(source.image(), scene.view);
    scene.view.step = faults.check_range("step", source.step(), 1.0 / 64, 16);
    scene.view.opacity_threshold = faults.check_range("opacity_threshold", source.opacity_threshold(), 0, 1);
    scene.view.shade = source.shade();
    scene.view.jitter = source.jitter();
    read_graph(source, folder, faults, scene);
    return scene;
  }

  Phong phong(const v1::Phong& source) {
    return {.ambient = faults.check_range("phong.ambient", source.ambient(), 0, 1.99),
            .diffuse = faults.check_range("phong.diffuse", source.diffuse(), 0, 1.99),
            .specular = faults.check_range("phong.specular", source.specular(), 0, 1.99),
            .shininess = faults.check_range("phong.shininess", source.shininess(), 1, 1000)};
  }

  CameraSettings camera(const std::string& field, const v1::Camera& source) {
    CameraSettings result;
    result.name = source.name();
    if (source.has_eye()) result.eye = finite_vector(faults, field + ".eye", source.eye());
    if (source.has_look_at()) result.look_at = finite_vector(faults, field + ".look_at", source.look_at());
    if (source.has_up()) result.up = direction(field + ".up", source.up());
    if (result.eye && result.look_at) {
      faults.check(!(*result.eye == *result.look_at), field + ".look_at", "another point than camera.eye", "the same");
    }
    if (source.has_fov_degrees()) {
      result.fov_degrees = source.fov_degrees();
      faults.check(source.fov_degrees() > 0 && source.fov_degrees() < 180, field + ".fov_degrees",
                   "more than 0 and less than 180", shown(source.fov_degrees()));
    }
    if (source.has_orthographic_height()) {
      result.orthographic_height = source.orthographic_height();
      faults.check(source.orthographic_height() > 0 && std::isfinite(source.orthographic_height()),
                   field + ".orthographic_height", "a number above 0", shown(source.orthographic_height()));
      faults.check(!source.has_fov_degrees(), field, "fov_degrees or orthographic_height", "both");
    }
    return result;
  }

  Vec3 direction(const std::string& field, const v1::Vector& source) {
    const Vec3 vector = finite_vector(faults, field, source);
    faults.check(length(vector) > 0, field, "a direction", "0 0 0");
    return vector;
  }

  CutPlane cut_plane(const std::string& field, const v1::CutPlane& source) {
    const Vec3 normal = direction(field + ".normal", source.normal());
    faults.check(std::isfinite(source.offset()), field + ".offset", "a finite number", shown(source.offset()));
    return {normal, source.offset()};
  }

  void image(const v1::ImageSettings& source, View& view) {
    view.width = faults.check_whole("image.width", source.width(), 1, kMaxImageSize);
    view.height = faults.check_whole("image.height", source.height(), 1, kMaxImageSize);
    const std::uint32_t samples = source.samples_per_axis();
    faults.check(samples == 1 || samples == 2 || samples == 4, "image.samples_per_axis", "1, 2 or 4",
                 std::to_string(samples));
    view.samples_per_axis = static_cast<int>(samples);
  }
};

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder) {
  Faults faults(name);
  Scene scene = Translator{faults, folder}.translate(parsed_message<v1::Scene>(text, kMaxNesting, faults));
  faults.throw_if_any();
  return scene;
}

Scene read_scene(const std::filesystem::path& path) {
  return parse_scene(read_text(path, "a scene file"), path.string(), path.parent_path());
}

bool is_scene_path(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".scene" || extension == ".textproto" || extension == ".pbtxt" || extension == ".txt";
}

}  // namespace gicube::scene

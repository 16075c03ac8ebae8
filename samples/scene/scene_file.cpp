#include "scene/scene_file.h"

#include <fmt/format.h>

#include <cmath>

#include "gicube/v1/scene.pb.h"
#include "scene/buckyball.h"
#include "scene/formats/whole_file.h"
#include "scene/graph/faults.h"
#include "scene/graph/graph_reader.h"

namespace gicube::samples {
namespace {

constexpr int kMaxNesting = 100;        // chosen: of braces; bounds the parser's stack
constexpr int kMaxCutPlanes = 6;        // as View
constexpr double kMaxImageSize = 4095;  // as View

// Turns the parsed message into a Scene; a fault leaves that part of the Scene at its default.
class Translator {
 public:
  Translator(Faults& faults, std::filesystem::path folder) : faults_(faults), folder_(std::move(folder)) {}

  Scene translate(const v1::Scene& source) {
    Scene scene;
    if (source.has_volume()) scene.volume = read_volume_source(faults_, "volume", source.volume(), folder_);
    if (source.has_volume() == source.has_world()) {
      faults_.fault("volume", "a volume or a world", source.has_world() ? "both" : "none");
    }
    if (source.has_transfer_function()) {
      scene.transfer_function =
          read_transfer_function_of(faults_, "transfer_function", source.transfer_function(), folder_);
    }
    if (source.has_phong()) scene.phong = phong(source.phong());
    if (source.camera_size() > 0) scene.camera = camera("camera", source.camera(0));
    for (int i = 1; i < source.camera_size(); ++i) {
      scene.more_cameras.push_back(camera(fmt::format("camera[{}]", i), source.camera(i)));
    }
    for (int i = 0; i < source.cut_plane_size(); ++i) cut_plane(i, source.cut_plane(i), scene.view);
    faults_.check(source.cut_plane_size() <= kMaxCutPlanes, "cut_plane", "at most 6",
                  std::to_string(source.cut_plane_size()));
    image(source.image(), scene.view);
    scene.view.step = number("step", source.step(), 1.0 / 64, 16);
    scene.view.opacity_threshold = number("opacity_threshold", source.opacity_threshold(), 0, 1);
    scene.view.shade = source.shade();
    scene.view.jitter = source.jitter();
    read_graph(source, folder_, faults_, scene);
    return scene;
  }

 private:
  double number(const std::string& field, double value, double low, double high) {
    faults_.check_range(field, value, low, high);
    return value;
  }

  Vec3 vector(const std::string& field, const v1::Vector& v) { return finite_vector(faults_, field, v); }

  Phong phong(const v1::Phong& source) {
    return {.ambient = number("phong.ambient", source.ambient(), 0, 1.99),
            .diffuse = number("phong.diffuse", source.diffuse(), 0, 1.99),
            .specular = number("phong.specular", source.specular(), 0, 1.99),
            .shininess = number("phong.shininess", source.shininess(), 1, 1000)};
  }

  CameraSettings camera(const std::string& field, const v1::Camera& source) {
    CameraSettings result;
    result.name = source.name();
    if (source.has_eye()) result.eye = vector(field + ".eye", source.eye());
    if (source.has_look_at()) result.look_at = vector(field + ".look_at", source.look_at());
    if (source.has_up()) {
      result.up = vector(field + ".up", source.up());
      faults_.check(length(*result.up) > 0, field + ".up", "a direction", "0 0 0");
    }
    if (result.eye && result.look_at) {
      faults_.check(!(*result.eye == *result.look_at), field + ".look_at", "another point than camera.eye", "the same");
    }
    if (source.has_fov_degrees()) {
      result.fov_degrees = source.fov_degrees();
      faults_.check(source.fov_degrees() > 0 && source.fov_degrees() < 180, field + ".fov_degrees",
                    "more than 0 and less than 180", shown(source.fov_degrees()));
    }
    if (source.has_orthographic_height()) {
      result.orthographic_height = source.orthographic_height();
      faults_.check(source.orthographic_height() > 0 && std::isfinite(source.orthographic_height()),
                    field + ".orthographic_height", "a number above 0", shown(source.orthographic_height()));
      faults_.check(!source.has_fov_degrees(), field, "fov_degrees or orthographic_height", "both");
    }
    return result;
  }

  void cut_plane(int index, const v1::CutPlane& source, View& view) {
    const std::string field = fmt::format("cut_plane[{}]", index);
    const Vec3 normal = vector(field + ".normal", source.normal());
    faults_.check(length(normal) > 0, field + ".normal", "a direction", "0 0 0");
    faults_.check(std::isfinite(source.offset()), field + ".offset", "a finite number", shown(source.offset()));
    view.cut_planes.push_back({normal, source.offset()});
  }

  void image(const v1::ImageSettings& source, View& view) {
    view.width = static_cast<int>(number("image.width", source.width(), 1, kMaxImageSize));
    view.height = static_cast<int>(number("image.height", source.height(), 1, kMaxImageSize));
    const std::uint32_t samples = source.samples_per_axis();
    faults_.check(samples == 1 || samples == 2 || samples == 4, "image.samples_per_axis", "1, 2 or 4",
                  std::to_string(samples));
    view.samples_per_axis = static_cast<int>(samples);
  }

  Faults& faults_;
  std::filesystem::path folder_;
};

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder) {
  Faults faults(name);
  Scene scene = Translator(faults, folder).translate(parsed_message<v1::Scene>(text, kMaxNesting, faults));
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

}  // namespace gicube::samples

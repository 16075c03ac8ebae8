#include "gicube/scene/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

constexpr double kMargin = 1.04;                    // chosen: the image is larger than the volume's box by this factor
constexpr Vec3 kDefaultDirection{-0.35, -1, 0.45};  // chosen: three-quarter view of a head whose face looks along -y

Vec3 times(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

// Physical voxel edges relative to the smallest one, in which angles are measured.
Vec3 relative(Vec3 spacing) { return (1 / std::min({spacing.x, spacing.y, spacing.z})) * spacing; }

// Extent of the box's corners as seen along the line of sight, in physical lengths.
struct SeenBox {
  double width = 0;     // twice the greatest distance from the line of sight, to the side
  double height = 0;    // and upwards
  double distance = 0;  // of the eye from look_at, so that a perspective image holds all corners
  double depth = 0;     // of the nearest corner before look_at
};

// Unit vectors of physical space; zero if the caller's directions are degenerate.
struct Frame {
  Vec3 towards_eye, right, up;
};

Frame make_frame(Vec3 up, Vec3 towards_eye) {
  const Vec3 right = unit_or_zero(cross(up, towards_eye));
  return {towards_eye, right, cross(towards_eye, right)};
}

SeenBox see_box(const SceneBox& box, Vec3 scale, Vec3 look_at, const Frame& frame, double tan_side, double tan_up) {
  SeenBox seen;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 voxel{(corner & 1) != 0 ? box.high.x : box.low.x, (corner & 2) != 0 ? box.high.y : box.low.y,
                     (corner & 4) != 0 ? box.high.z : box.low.z};
    const Vec3 offset = times(voxel - look_at, scale);
    const double side = std::abs(dot(offset, frame.right)), up = std::abs(dot(offset, frame.up));
    const double near = dot(offset, frame.towards_eye);
    seen.width = std::max(seen.width, 2 * side);
    seen.height = std::max(seen.height, 2 * up);
    seen.depth = std::max(seen.depth, near);
    seen.distance = std::max(seen.distance, near + kMargin * std::max(side / tan_side, up / tan_up));
  }
  return seen;
}

Vec3 choose_up(const CameraSettings& camera, Vec3 towards_eye) {
  const Vec3 up = camera.up.value_or(Vec3{0, 0, 1});
  const bool along = length(cross(up, towards_eye)) < 1e-6 * length(up);
  return along && !camera.up ? Vec3{0, 1, 0} : up;
}

void allow_outside_in(Node& node) {
  if (auto* scan = std::get_if<ScanContent>(&node.content)) scan->source.allow_outside = true;
  for (Node& child : node.children) allow_outside_in(child);
}

}  // namespace

Vec3 see_from(const std::string& name, WorldAxes axes, std::optional<Vec3>& up) {
  struct Named {
    const char* name;
    Vec3 towards_eye;
    bool of_patient;  // only with a patient
  };
  const bool patient = axes == WorldAxes::kPatient;
  const double left = patient ? 1 : -1;
  const std::array views{
      Named{"front", {0, -1, 0}, false},    Named{"back", {0, 1, 0}, false},     Named{"left", {left, 0, 0}, false},
      Named{"right", {-left, 0, 0}, false}, Named{"top", {0, 0, 1}, false},      Named{"bottom", {0, 0, -1}, false},
      Named{"iso", {1, -1, 1}, false},      Named{"anterior", {0, -1, 0}, true}, Named{"posterior", {0, 1, 0}, true},
      Named{"superior", {0, 0, 1}, true},   Named{"inferior", {0, 0, -1}, true}};
  const auto* const found = std::ranges::find_if(views, [&](const Named& view) { return name == view.name; });
  if (found == views.end() || (found->of_patient && !patient)) {
    std::string names;
    for (const Named& view : views) {
      if (patient || !view.of_patient) names += (names.empty() ? "" : ", ") + std::string(view.name);
    }
    throw InputError("view", "one of " + names + (patient ? "" : " (the file says nothing of a patient)"),
                     in_quotes(name));
  }
  if (!up && found->towards_eye.x == 0 && found->towards_eye.y == 0)
    up = Vec3{0, patient || found->towards_eye.z < 0 ? -1.0 : 1.0, 0};
  return found->towards_eye;
}

void fit_camera(const CameraSettings& asked, const SceneBox& box, const Vec3& spacing, View& view, WorldAxes axes) {
  CameraSettings camera = asked;
  const Vec3 direction = camera.from.empty() ? kDefaultDirection : see_from(camera.from, axes, camera.up);
  const Vec3 scale = relative(spacing), inverse{1 / scale.x, 1 / scale.y, 1 / scale.z};
  view.fov_degrees = camera.fov_degrees.value_or(view.fov_degrees);
  if (!(view.fov_degrees > 0 && view.fov_degrees < 180)) {
    throw InputError("field of view", "more than 0 and less than 180 degrees", shown(view.fov_degrees));
  }
  view.look_at = camera.look_at.value_or(0.5 * (box.low + box.high));
  const Vec3 sight = camera.eye ? times(*camera.eye - view.look_at, scale) : direction;
  const Vec3 towards_eye = unit_or_zero(sight);  // zero: the driver refuses it
  view.up = choose_up(camera, towards_eye);

  const Frame frame = make_frame(view.up, towards_eye);
  const double aspect = double(view.width) / double(view.height);
  const double tan_up = std::tan(view.fov_degrees * std::numbers::pi / 360);
  const SeenBox seen = see_box(box, scale, view.look_at, frame, tan_up * aspect, tan_up);

  view.orthographic_height = camera.orthographic_height.value_or(0);
  // Parallel rays start at the eye's plane: keep it before the whole box.
  const double distance = view.orthographic_height > 0 ? kMargin * seen.depth + 1 : seen.distance;
  view.eye = camera.eye.value_or(view.look_at + times(distance * towards_eye, inverse));
}

Vec3 shoulder_light(const View& view, const Vec3& spacing) {
  const Frame frame = make_frame(view.up, unit_or_zero(times(view.eye - view.look_at, relative(spacing))));
  return frame.towards_eye + 0.55 * frame.up - 0.45 * frame.right;  // chosen: relief, and few shadows
}

void allow_outside(Scene& scene) {
  scene.volume.allow_outside = true;
  if (scene.world) allow_outside_in(scene.world->root);
}

void choose_camera(Scene& scene, const std::string& name) {
  if (scene.camera.name == name) return;
  const auto found = std::ranges::find(scene.more_cameras, name, &CameraSettings::name);
  if (found != scene.more_cameras.end()) return std::swap(*found, scene.camera);
  std::string names = scene.camera.name;
  for (const CameraSettings& camera : scene.more_cameras) names += (names.empty() ? "" : ", ") + camera.name;
  throw InputError("camera", names.empty() ? "a scene with named cameras" : "one of " + names, in_quotes(name));
}

}  // namespace gicube::scene

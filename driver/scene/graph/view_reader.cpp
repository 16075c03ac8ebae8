// Parts of a scene file for the camera and the image.
#include <cmath>

#include "scene/graph/graph_reader.h"

namespace gicube::scene {
namespace {

constexpr int kMaxImageSize = 4095;  // as View

}  // namespace

Phong read_phong(Faults& faults, const v1::Phong& source) {
  return {.ambient = faults.check_range("phong.ambient", source.ambient(), 0, 1.99),
          .diffuse = faults.check_range("phong.diffuse", source.diffuse(), 0, 1.99),
          .specular = faults.check_range("phong.specular", source.specular(), 0, 1.99),
          .shininess = faults.check_range("phong.shininess", source.shininess(), 1, 1000)};
}

CameraSettings read_camera(Faults& faults, const std::string& field, const v1::Camera& source) {
  CameraSettings result;
  result.name = source.name();
  if (source.has_eye()) result.eye = finite_vector(faults, field + ".eye", source.eye());
  if (source.has_look_at()) result.look_at = finite_vector(faults, field + ".look_at", source.look_at());
  if (source.has_up()) result.up = read_direction(faults, field + ".up", source.up());
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

Vec3 read_direction(Faults& faults, const std::string& field, const v1::Vector& source) {
  const Vec3 vector = finite_vector(faults, field, source);
  faults.check(length(vector) > 0, field, "a direction", "0 0 0");
  return vector;
}

void read_image(Faults& faults, const v1::ImageSettings& source, View& view) {
  view.width = faults.check_whole("image.width", source.width(), 1, kMaxImageSize);
  view.height = faults.check_whole("image.height", source.height(), 1, kMaxImageSize);
  const std::uint32_t samples = source.samples_per_axis();
  faults.check(samples == 1 || samples == 2 || samples == 4, "image.samples_per_axis", "1, 2 or 4",
               std::to_string(samples));
  view.samples_per_axis = static_cast<int>(samples);
}

}  // namespace gicube::scene

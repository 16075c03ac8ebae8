#include "defaults.h"

#include "gicube/board.h"
#include "handle.h"
#include "record.h"

namespace gicube::c_api {

gicube_open_options default_open_options() {
  const OpenOptions options;
  gicube_open_options record{};
  record.back_pressure = static_cast<std::int32_t>(options.back_pressure);
  record.watchdog_ms = static_cast<std::uint64_t>(options.watchdog.count());
  record.max_rays = options.max_rays;
  record.keep_volume = options.keep_volume;
  record.reopen_attempts = options.reopen_attempts;
  record.force = options.force;
  record.wait_for_board_ms = static_cast<std::uint64_t>(options.wait_for_board.count());
  return record;
}

gicube_volume default_volume() {
  const VolumeView volume;
  gicube_volume record{};
  put(volume.spacing, record.spacing);
  return record;
}

gicube_shading default_shading() {
  const Shading shading;
  gicube_shading record{};
  record.ambient = shading.phong.ambient;
  record.diffuse = shading.phong.diffuse;
  record.specular = shading.phong.specular;
  record.shininess = shading.phong.shininess;
  return record;
}

gicube_material default_material() { return {}; }

gicube_illumination default_illumination() {
  const Illumination settings;
  gicube_illumination record{};
  record.albedo = static_cast<std::int32_t>(settings.albedo);
  record.rules = static_cast<std::int32_t>(settings.rules);
  record.rays_per_face_voxel = settings.rays_per_face_voxel;
  record.step = settings.step;
  record.jitter = settings.jitter;
  record.leap = settings.leap;
  record.lifetime = settings.lifetime;
  record.seed = settings.seed;
  return record;
}

gicube_view default_view() {
  const View view;
  gicube_view record{};
  record.width = view.width;
  record.height = view.height;
  record.samples_per_axis = view.samples_per_axis;
  put(view.eye, record.eye);
  put(view.look_at, record.look_at);
  put(view.up, record.up);
  record.fov_degrees = view.fov_degrees;
  record.orthographic_height = view.orthographic_height;
  record.step = view.step;
  record.opacity_threshold = view.opacity_threshold;
  record.exposure = view.exposure;
  record.filter = static_cast<std::int32_t>(view.filter);
  record.shade = view.shade;
  record.jitter = view.jitter;
  record.leap = view.leap;
  record.irradiance = view.irradiance;
  record.incident = view.incident;
  record.scatter = view.scatter;
  record.high_albedo = view.high_albedo;
  record.lifetime = view.lifetime;
  record.seed = view.seed;
  return record;
}

gicube_ray_request default_ray_request() {
  const RayRequest request;
  gicube_ray_request record{};
  record.type = static_cast<std::int32_t>(request.type);
  record.opacity = request.opacity;
  record.albedo = static_cast<std::int32_t>(request.albedo);
  record.rules = static_cast<std::int32_t>(request.rules);
  record.lifetime = request.lifetime;
  record.step = request.step;
  record.words = static_cast<std::int32_t>(request.words);
  return record;
}

gicube_pair_request default_pair_request() {
  const PairRequest request;
  gicube_pair_request record{};
  record.rays = request.rays;
  record.first = request.first;
  record.seed = request.seed;
  record.opacity = request.opacity;
  record.made = static_cast<std::int32_t>(request.made);
  return record;
}

}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_open_options_init(gicube_open_options* options, size_t size) {
  return call([&] { init_record("options", options, size, default_open_options()); });
}

gicube_status gicube_board_info_init(gicube_board_info* info, size_t size) {
  return call([&] { init_record("info", info, size, gicube_board_info{}); });
}

gicube_status gicube_volume_init(gicube_volume* volume, size_t size) {
  return call([&] { init_record("volume", volume, size, default_volume()); });
}

gicube_status gicube_shading_init(gicube_shading* shading, size_t size) {
  return call([&] { init_record("shading", shading, size, default_shading()); });
}

gicube_status gicube_material_init(gicube_material* material, size_t size) {
  return call([&] { init_record("material", material, size, default_material()); });
}

gicube_status gicube_illumination_init(gicube_illumination* settings, size_t size) {
  return call([&] { init_record("settings", settings, size, default_illumination()); });
}

gicube_status gicube_lighting_report_init(gicube_lighting_report* report, size_t size) {
  return call([&] { init_record("report", report, size, gicube_lighting_report{}); });
}

gicube_status gicube_view_init(gicube_view* view, size_t size) {
  return call([&] { init_record("view", view, size, default_view()); });
}

gicube_status gicube_ray_request_init(gicube_ray_request* request, size_t size) {
  return call([&] { init_record("request", request, size, default_ray_request()); });
}

gicube_status gicube_pair_request_init(gicube_pair_request* request, size_t size) {
  return call([&] { init_record("request", request, size, default_pair_request()); });
}

gicube_status gicube_batch_report_init(gicube_batch_report* report, size_t size) {
  return call([&] {
    init_record("report", report, size, gicube_batch_report{});
    report->lighting.size = sizeof report->lighting;
  });
}
}

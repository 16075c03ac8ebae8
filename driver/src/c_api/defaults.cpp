// The records' defaults: those of the C++ API.
#include "fields.h"

namespace gicube::c_api {

gicube_volume default_volume() {
  gicube_volume record{};
  put(VolumeView().spacing, record.spacing);
  return record;
}

}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_open_options_init(gicube_open_options* options, size_t size) {
  return call(
      [&] { init_record("options", options, size, default_record<gicube_open_options, gicube::OpenOptions>()); });
}

gicube_status gicube_board_info_init(gicube_board_info* info, size_t size) {
  return call([&] { init_record("info", info, size, gicube_board_info{}); });
}

gicube_status gicube_volume_init(gicube_volume* volume, size_t size) {
  return call([&] { init_record("volume", volume, size, default_volume()); });
}

gicube_status gicube_shading_init(gicube_shading* shading, size_t size) {
  return call([&] { init_record("shading", shading, size, default_record<gicube_shading, gicube::Shading>()); });
}

gicube_status gicube_material_init(gicube_material* material, size_t size) {
  return call([&] { init_record("material", material, size, default_record<gicube_material, gicube::Material>()); });
}

gicube_status gicube_illumination_init(gicube_illumination* settings, size_t size) {
  return call(
      [&] { init_record("settings", settings, size, default_record<gicube_illumination, gicube::Illumination>()); });
}

gicube_status gicube_lighting_report_init(gicube_lighting_report* report, size_t size) {
  return call([&] { init_record("report", report, size, gicube_lighting_report{}); });
}

gicube_status gicube_view_init(gicube_view* view, size_t size) {
  return call([&] { init_record("view", view, size, default_record<gicube_view, gicube::View>()); });
}

gicube_status gicube_ray_request_init(gicube_ray_request* request, size_t size) {
  return call([&] { init_record("request", request, size, default_record<gicube_ray_request, gicube::RayRequest>()); });
}

gicube_status gicube_pair_request_init(gicube_pair_request* request, size_t size) {
  return call(
      [&] { init_record("request", request, size, default_record<gicube_pair_request, gicube::PairRequest>()); });
}

gicube_status gicube_batch_report_init(gicube_batch_report* report, size_t size) {
  return call([&] {
    init_record("report", report, size, gicube_batch_report{});
    report->lighting.size = sizeof report->lighting;
  });
}
}

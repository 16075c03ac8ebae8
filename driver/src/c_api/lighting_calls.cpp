// Lights and irradiance.
#include "fields.h"

namespace gicube::c_api {
namespace {

Light to_light(const gicube_light& light, std::size_t index) {
  const std::string name = "lights[" + std::to_string(index) + "]";
  if (light.reserved != 0) throw BadArgument(name + ".reserved", "0", std::to_string(light.reserved));
  switch (light.kind) {
    case GICUBE_LIGHT_POINT: return PointLight{to_vec3(light.position), light.power};
    case GICUBE_LIGHT_DIRECTIONAL: return DirectionalLight{to_vec3(light.position), light.power};
    case GICUBE_LIGHT_RECTANGLE:
      return RectangleLight{to_vec3(light.position), to_vec3(light.edge_u), to_vec3(light.edge_v), light.power};
    case GICUBE_LIGHT_SPHERE: return SphereLight{to_vec3(light.position), light.radius, light.power};
    default: throw BadArgument(name + ".kind", "0..3", std::to_string(light.kind));
  }
}

}  // namespace

gicube_lighting_report to_c(const LightingReport& report) {
  gicube_lighting_report record{};
  record.size = sizeof record;
  record.warnings = static_cast<std::uint32_t>(report.warnings.size());
  record.rays = report.rays;
  record.emitted = report.emitted;
  record.deposited = report.deposited;
  record.escaped = report.escaped;
  record.scattered_away = report.scattered_away;
  record.given_up = report.given_up;
  record.clipped = report.clipped;
  record.unit = report.unit;
  return record;
}

}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_illuminate(gicube_board* board, const gicube_light* lights, size_t count,
                                const gicube_illumination* settings, gicube_progress progress, void* user,
                                gicube_lighting_report* report) {
  return call([&] {
    gicube_board& handle = checked_board(board);
    checked("lights", lights, count);
    const auto how = read_fields<gicube_illumination, gicube::Illumination>("settings", settings);
    if (report != nullptr) check_size<gicube_lighting_report>("report", report->size, sizeof *report);
    std::vector<gicube::Light> all;
    for (std::size_t i = 0; i < count; ++i) all.push_back(to_light(lights[i], i));
    const gicube::LightingReport result = handle.board.illuminate(all, how, to_progress(progress, user));
    if (report != nullptr) write_record("report", report, to_c(result));
    const std::scoped_lock lock(handle.mutex);
    handle.warnings = result.warnings;
  });
}

const char* gicube_lighting_warning(gicube_board* board, uint32_t index) {
  const char* text = nullptr;
  (void)call([&] {
    gicube_board& handle = checked_board(board);
    const std::scoped_lock lock(handle.mutex);
    if (index < handle.warnings.size()) text = handle.warnings[index].c_str();
  });
  return text;
}

gicube_status gicube_read_irradiance(gicube_board* board, const gicube_box* box, float* values, size_t count) {
  if (box != nullptr) return read_box(board, box, values, count, &gicube::Board::read_irradiance);
  return call([&] {
    gicube_board& handle = checked_board(board);
    checked("values", values);
    const std::vector<float> read = handle.board.read_irradiance();
    check_count("count", count, read.size());
    std::copy(read.begin(), read.end(), values);
  });
}

gicube_status gicube_write_irradiance(gicube_board* board, const gicube_box* box, const float* values, size_t count) {
  return write_box(board, box, values, count, &gicube::Board::write_irradiance);
}

gicube_status gicube_clear_irradiance(gicube_board* board, double unit) {
  return call([&] { checked_board(board).board.clear_irradiance(unit); });
}

gicube_status gicube_clear_sums(gicube_board* board, double unit) {
  return call([&] { checked_board(board).board.clear_sums(unit); });
}

gicube_status gicube_read_sums(gicube_board* board, const gicube_box* box, float* values, size_t count) {
  return read_box(board, box, values, count, &gicube::Board::read_sums);
}
}

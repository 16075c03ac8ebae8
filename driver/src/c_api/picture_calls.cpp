// Lights, irradiance, pictures.
#include "fields.h"

namespace gicube::c_api {
namespace {

Light to_light(const gicube_light& light, std::size_t index) {
  const std::string name = "lights[" + std::to_string(index) + "]";
  check_reserved(name + ".reserved", light.reserved);
  switch (light.kind) {
    case GICUBE_LIGHT_POINT: return PointLight{to_vec3(light.position), light.power};
    case GICUBE_LIGHT_DIRECTIONAL: return DirectionalLight{to_vec3(light.position), light.power};
    case GICUBE_LIGHT_RECTANGLE:
      return RectangleLight{to_vec3(light.position), to_vec3(light.edge_u), to_vec3(light.edge_v), light.power};
    case GICUBE_LIGHT_SPHERE: return SphereLight{to_vec3(light.position), light.radius, light.power};
    default: throw BadArgument(name + ".kind", "0..3", std::to_string(light.kind));
  }
}

View to_view(const gicube_view* given) {
  gicube_view record;
  View view = read_fields<View>("view", given, record);
  constexpr std::uint32_t kMax = 6;
  if (record.cut_plane_count > kMax) {
    throw BadArgument("view.cut_plane_count", "at most 6", std::to_string(record.cut_plane_count));
  }
  checked("view.cut_planes", record.cut_planes, record.cut_plane_count);
  for (std::uint32_t i = 0; i < record.cut_plane_count; ++i) {
    view.cut_planes.push_back({to_vec3(record.cut_planes[i].normal), record.cut_planes[i].offset});
  }
  return view;
}

// The picture that there is now; what another thread renders meanwhile is its own affair.
std::size_t pixels_of(std::pair<int, int> size) {
  return static_cast<std::size_t>(size.first) * static_cast<std::size_t>(size.second);
}

void render(gicube_board& handle, const View& view, const Progress& progress) {
  handle.board.render_to_framebuffer(view, progress);
  const std::scoped_lock lock(handle.mutex);
  handle.framebuffer = {view.width, view.height};
}

void read(gicube_board& handle, gicube_pixel* pixels, std::size_t count) {
  const Image image = handle.board.read_framebuffer();
  check_count("count", count, image.pixels.size());
  for (const Pixel& pixel : image.pixels) *pixels++ = {pixel.red, pixel.green, pixel.blue, 0, pixel.alpha};
}

}  // namespace

gicube_lighting_report to_c(const LightingReport& report) {
  return {.size = sizeof(gicube_lighting_report),
          .warnings = static_cast<std::uint32_t>(report.warnings.size()),
          .rays = report.rays,
          .emitted = report.emitted,
          .deposited = report.deposited,
          .escaped = report.escaped,
          .scattered_away = report.scattered_away,
          .given_up = report.given_up,
          .clipped = report.clipped,
          .unit = report.unit};
}

}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_illumination_init(gicube_illumination* settings, size_t size) {
  return init<gicube::Illumination>("settings", settings, size);
}

gicube_status gicube_lighting_report_init(gicube_lighting_report* report, size_t size) {
  return call([&] { write_record("report", report, size, {}); });
}

gicube_status gicube_view_init(gicube_view* view, size_t size) { return init<gicube::View>("view", view, size); }

gicube_status gicube_illuminate(gicube_board* board, const gicube_light* lights, size_t count,
                                const gicube_illumination* settings, gicube_progress progress, void* user,
                                gicube_lighting_report* report) {
  return on_board(board, [&](gicube_board& handle) {
    checked("lights", lights, count);
    const auto how = read_fields<gicube::Illumination>("settings", settings);
    check_optional("report", report);
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
  (void)on_board(board, [&](gicube_board& handle) {
    const std::scoped_lock lock(handle.mutex);
    if (index < handle.warnings.size()) text = handle.warnings[index].c_str();
  });
  return text;
}

gicube_status gicube_read_irradiance(gicube_board* board, const gicube_box* box, float* values, size_t count) {
  if (box != nullptr) return read_box(board, box, values, count, &gicube::Board::read_irradiance);
  return on_board(board, [&](gicube_board& handle) {
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
  return on_board(board, [&](gicube_board& handle) { handle.board.clear_irradiance(unit); });
}

gicube_status gicube_clear_sums(gicube_board* board, double unit) {
  return on_board(board, [&](gicube_board& handle) { handle.board.clear_sums(unit); });
}

gicube_status gicube_read_sums(gicube_board* board, const gicube_box* box, float* values, size_t count) {
  return read_box(board, box, values, count, &gicube::Board::read_sums);
}

gicube_status gicube_render_to_framebuffer(gicube_board* board, const gicube_view* view, gicube_progress progress,
                                           void* user) {
  return on_board(board, [&](gicube_board& handle) { render(handle, to_view(view), to_progress(progress, user)); });
}

gicube_status gicube_get_framebuffer_size(gicube_board* board, int32_t* width, int32_t* height) {
  return on_board(board, [&](gicube_board& handle) {
    checked("width", width);
    checked("height", height);
    const std::scoped_lock lock(handle.mutex);
    *width = handle.framebuffer.first;
    *height = handle.framebuffer.second;
  });
}

gicube_status gicube_read_framebuffer(gicube_board* board, gicube_pixel* pixels, size_t count) {
  return on_board(board, [&](gicube_board& handle) {
    checked("pixels", pixels);
    std::size_t there = 0;
    {
      const std::scoped_lock lock(handle.mutex);
      there = pixels_of(handle.framebuffer);
    }
    if (there > 0) check_count("count", count, there);  // before anything is transferred; else the board says why not
    read(handle, pixels, count);
  });
}

gicube_status gicube_render(gicube_board* board, const gicube_view* view, gicube_pixel* pixels, size_t count,
                            gicube_progress progress, void* user) {
  return on_board(board, [&](gicube_board& handle) {
    const gicube::View picture = to_view(view);
    checked("pixels", pixels);
    if (picture.width > 0 && picture.height > 0) {  // else the driver names what is wrong with them
      check_count("count", count, pixels_of({picture.width, picture.height}));
    }
    render(handle, picture, to_progress(progress, user));
    read(handle, pixels, count);
  });
}
}

// Volumes and their appearance; light and pictures.
#include <algorithm>

#include "call.h"

namespace gicube::c_api {
namespace {

Material to_material(const gicube_material* given) {
  gicube_material record;
  Material material = read_fields<Material>("material", given, record);
  expect(record.parameter_count <= 32, "material.parameter_count", "at most 32", record.parameter_count);
  const float* parameters = checked("material.parameters", record.parameters, record.parameter_count);
  material.parameters.assign(parameters, parameters + record.parameter_count);
  return material;
}

gicube_scatter_event to_c(const ScatterEvent& event) {
  auto record = to_record<gicube_scatter_event>(event);
  record.size = sizeof record;
  record.parameters = event.parameters.data();
  record.parameter_count = event.parameters.size();
  return record;
}

ScatteringRoutine to_routine(gicube_scattering_routine routine, void* user) {
  if (routine == nullptr) return {};
  return [routine, user](const ScatterEvent& event) -> ScatterAnswer {
    const gicube_scatter_event record = to_c(event);
    auto answer = to_record<gicube_scatter_answer>(ScatterAnswer{});
    if (routine(user, &record, &answer) != 0) throw Stopped("the scattering routine ended the call");
    return from_record<ScatterAnswer>("answer", answer);
  };
}

VoxelBox to_box(const gicube_box* given) { return from_record<VoxelBox>("box", checked("box", given)); }

std::size_t voxels_of(const VoxelBox& box) {
  std::size_t count = 1;
  for (const int size : box.size) {
    expect(size >= 1 && size <= 1024, "box.size", "1..1024 voxels each", size);
    count *= static_cast<std::size_t>(size);
  }
  return count;
}

// Values of a voxel.
using WordsOf = std::size_t (*)(const Board&);
std::size_t one_word(const Board&) { return 1; }
std::size_t irradiance_words(const Board& board) { return static_cast<std::size_t>(board.info().irradiance_words); }

void read_volume(Board& of, const VoxelBox& box, std::span<float> values) { of.volume().read(box, values); }
void read_irradiance(Board& of, const VoxelBox& box, std::span<float> values) { of.light().read(box, values); }
void read_sums(Board& of, const VoxelBox& box, std::span<float> values) { of.light().read_sums(box, values); }

gicube_status read_box(gicube_board* board, const gicube_box* box, float* values, std::size_t count,
                       void (*read)(Board&, const VoxelBox&, std::span<float>), WordsOf words = one_word) {
  return on_board(board, [&](gicube_board& handle) {
    const VoxelBox voxels = to_box(box);
    check_count("count", count, words(handle.board) * voxels_of(voxels));
    read(handle.board, voxels, {&checked("values", values), count});
  });
}

gicube_status write_box(gicube_board* board, const gicube_box* box, const float* values, std::size_t count,
                        void (Board::*write)(const VoxelBox&, std::span<const float>), WordsOf words = one_word) {
  return on_board(board, [&](gicube_board& handle) {
    const VoxelBox voxels = to_box(box);
    check_count("count", count, words(handle.board) * voxels_of(voxels));
    (handle.board.*write)(voxels, {&checked("values", values), count});
  });
}

std::size_t pixels_of(std::pair<int, int> size) {
  return static_cast<std::size_t>(size.first) * static_cast<std::size_t>(size.second);
}

void render(gicube_board& handle, const View& view, const Progress& progress) {
  handle.board.render_to_framebuffer(view, progress);
  remember_view(handle, view);
}

}  // namespace

void remember_view(gicube_board& handle, const View& view) {
  const std::scoped_lock lock(handle.mutex);
  handle.framebuffer = {view.width, view.height};
  handle.sampling = gicube::sampling_of(view);
}

void hand_over(gicube_board& handle, const Image& image, gicube_pixel* pixels, std::size_t count) {
  check_count("count", count, image.pixels.size());
  std::string why = handle.board.why_invisible(image);
  const std::scoped_lock lock(handle.mutex);
  handle.why_invisible = std::move(why);
  for (const Pixel& pixel : image.pixels) *pixels++ = to_record<gicube_pixel>(pixel);
}

void hand_over(gicube_board& handle, const LightingReport& result, gicube_lighting_report* report) {
  if (report != nullptr) write_record("report", report, to_c(result));
  const std::scoped_lock lock(handle.mutex);
  handle.warnings = result.warnings;
}

VolumeView to_volume(const gicube_volume* given) {
  gicube_volume record;
  auto volume = read_fields<VolumeView>("volume", given, record);
  volume.samples = {static_cast<const std::byte*>(record.samples), record.sample_bytes};
  if (record.samples == nullptr) throw BadArgument("volume.samples", "a pointer", "NULL");
  if (truth("volume.has_range", record.has_range)) volume.range = ValueRange{record.low, record.high};
  volume.gradients = {checked("volume.gradients", record.gradients, record.gradient_count), record.gradient_count};
  volume.tags = {checked("volume.tags", record.tags, record.tag_count), record.tag_count};
  volume.colours = {checked("volume.colours", record.colours, record.colour_bytes), record.colour_bytes};
  return volume;
}

template <>
Light from_record<Light>(const std::string& name, gicube_light light) {
  expect(light.reserved == 0, name + ".reserved", "0", light.reserved);
  switch (light.kind) {
    case GICUBE_LIGHT_POINT: return PointLight{to_vec3(light.position), light.power};
    case GICUBE_LIGHT_DIRECTIONAL: return DirectionalLight{to_vec3(light.position), light.power};
    case GICUBE_LIGHT_RECTANGLE:
      return RectangleLight{to_vec3(light.position), to_vec3(light.edge_u), to_vec3(light.edge_v), light.power};
    case GICUBE_LIGHT_SPHERE: return SphereLight{to_vec3(light.position), light.radius, light.power};
    default: throw BadArgument(name + ".kind", "0..3", std::to_string(light.kind));
  }
}

Illumination to_illumination(const gicube_illumination* settings) {
  gicube_illumination record;
  auto how = read_fields<Illumination>("settings", settings, record);
  const double* colour = checked("settings.light_colours", record.light_colours, 3 * record.light_colour_count);
  for (std::size_t i = 0; i < record.light_colour_count; ++i, colour += 3) {
    how.light_colours.push_back({colour[0], colour[1], colour[2]});
  }
  return how;
}

View to_view(const gicube_view* given, const std::string& name) {
  gicube_view record;
  View view = read_fields<View>(name.c_str(), given, record);
  expect(record.cut_plane_count <= 6, name + ".cut_plane_count", "at most 6", record.cut_plane_count);
  view.cut_planes = from_records<CutPlane>(name + ".cut_planes", record.cut_planes, record.cut_plane_count);
  expect(record.lamp_count <= kMaxLamps, name + ".lamp_count", "at most 32", record.lamp_count);
  view.lamps = from_records<Lamp>(name + ".lamps", record.lamps, record.lamp_count);
  for (std::size_t i = 0; i < record.lamp_count; ++i) {
    view.lamps[i].light = from_record<Light>(fmt::format("{}.lamps[{}].light", name, i), record.lamps[i].light);
  }
  return view;
}

gicube_lighting_report to_c(const LightingReport& report) {
  auto record = to_record<gicube_lighting_report>(report);
  record.warnings = static_cast<std::uint32_t>(report.warnings.size());
  for (std::size_t c = 0; c < report.colours.size(); ++c) {
    record.colours[c] = to_record<gicube_light_energy>(report.colours[c]);
  }
  return record;
}

}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_volume_init(gicube_volume* volume, size_t size) {
  return init<gicube::VolumeView>("volume", volume, size);
}

gicube_status gicube_shading_init(gicube_shading* shading, size_t size) {
  return init<gicube::Shading>("shading", shading, size);
}

gicube_status gicube_material_init(gicube_material* material, size_t size) {
  return init<gicube::Material>("material", material, size);
}

gicube_status gicube_load_volume(gicube_board* board, const gicube_volume* volume, gicube_progress progress,
                                 void* user) {
  return on_board(
      board, [&](gicube_board& handle) { handle.board.load_volume(to_volume(volume), to_progress(progress, user)); });
}

gicube_status gicube_value_range(gicube_board* board, double* low, double* high) {
  return call([&] {
    checked("low", low);
    checked("high", high);
    const gicube::ValueRange range = checked_board(board).board.value_range();
    *low = range.low;
    *high = range.high;
  });
}

gicube_status gicube_read_volume(gicube_board* board, const gicube_box* box, float* values, size_t count) {
  return read_box(board, box, values, count, read_volume);
}

gicube_status gicube_write_volume(gicube_board* board, const gicube_box* box, const float* values, size_t count) {
  return write_box(board, box, values, count, &gicube::Board::write_volume);
}

gicube_status gicube_verify_volume(gicube_board* board, size_t* damaged, size_t capacity, size_t* damaged_count) {
  return call([&] {
    checked("damaged_count", damaged_count) = 0;
    gicube_board& handle = checked_board(board);
    checked("damaged", damaged, capacity);
    const std::vector<std::size_t> blocks = handle.board.verify_volume();
    std::copy_n(blocks.begin(), std::min(capacity, blocks.size()), damaged);
    *damaged_count = blocks.size();
  });
}

gicube_status gicube_set_transfer_function(gicube_board* board, int32_t tag, const gicube_colour_point* colours,
                                           size_t colour_count, const gicube_opacity_point* opacities,
                                           size_t opacity_count) {
  return on_board(board, [&](gicube_board& handle) {
    const gicube::TransferFunction function{from_records<gicube::ColourPoint>("colours", colours, colour_count),
                                            from_records<gicube::OpacityPoint>("opacities", opacities, opacity_count)};
    handle.board.set_transfer_function(function, tag);
  });
}

gicube_status gicube_set_shading(gicube_board* board, const gicube_shading* shading) {
  return on_board(
      board, [&](gicube_board& handle) { handle.board.set_shading(read_fields<gicube::Shading>("shading", shading)); });
}

gicube_status gicube_set_material(gicube_board* board, int32_t tag, const gicube_material* material) {
  return on_board(board, [&](gicube_board& handle) { handle.board.set_material(to_material(material), tag); });
}

gicube_status gicube_set_scattering_routine(gicube_board* board, gicube_scattering_routine routine, void* user,
                                            uint64_t time_per_ray_ps) {
  return call([&] { checked_board(board).board.set_scattering_routine(to_routine(routine, user), time_per_ray_ps); });
}

gicube_status gicube_set_gradient_codebook(gicube_board* board, const double* codebook, size_t codes) {
  return on_board(board, [&](gicube_board& handle) {
    gicube::expect(codes <= 2048, "codes", "at most 2048", codes);
    checked("codebook", codebook, 3 * codes);
    std::vector<gicube::Vec3> directions;
    for (std::size_t i = 0; i < codes; ++i) {
      directions.push_back({codebook[3 * i], codebook[3 * i + 1], codebook[3 * i + 2]});
    }
    handle.board.set_gradient_codebook(directions);
  });
}

gicube_status gicube_get_blocks(gicube_board* board, int32_t blocks[3]) {
  return call([&] {
    checked("blocks", blocks);
    const gicube::Dims dims = checked_board(board).board.blocks();
    std::copy(dims.begin(), dims.end(), blocks);
  });
}

gicube_status gicube_set_empty_flags(gicube_board* board, const uint8_t* flags, size_t count) {
  return on_board(board, [&](gicube_board& handle) {
    handle.board.set_empty_flags({checked("flags", flags, count), count});
  });
}

gicube_status gicube_get_empty_flags(gicube_board* board, uint8_t* flags, size_t count) {
  return call([&] {
    const std::vector<std::uint8_t> found = checked_board(board).board.empty_flags();
    check_count("count", count, found.size());
    checked("flags", flags, count);
    std::copy(found.begin(), found.end(), flags);
  });
}

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
    const auto all = from_records<gicube::Light>("lights", lights, count);
    const gicube::Illumination how = to_illumination(settings);
    check_optional("report", report);
    hand_over(handle, handle.board.illuminate(all, how, to_progress(progress, user)), report);
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
  if (box != nullptr) return read_box(board, box, values, count, read_irradiance, irradiance_words);
  return on_board(board, [&](gicube_board& handle) {
    checked("values", values);
    const std::vector<float> read = handle.board.read_irradiance();
    check_count("count", count, read.size());
    std::copy(read.begin(), read.end(), values);
  });
}

gicube_status gicube_write_irradiance(gicube_board* board, const gicube_box* box, const float* values, size_t count) {
  return write_box(board, box, values, count, &gicube::Board::write_irradiance, irradiance_words);
}

gicube_status gicube_clear_irradiance(gicube_board* board, double unit) {
  return on_board(board, [&](gicube_board& handle) { handle.board.clear_irradiance(unit); });
}

gicube_status gicube_clear_sums(gicube_board* board, double unit) {
  return on_board(board, [&](gicube_board& handle) { handle.board.clear_sums(unit); });
}

gicube_status gicube_read_sums(gicube_board* board, const gicube_box* box, float* values, size_t count) {
  return read_box(board, box, values, count, read_sums);
}

gicube_status gicube_render_to_framebuffer(gicube_board* board, const gicube_view* view, gicube_progress progress,
                                           void* user) {
  return on_board(board,
                  [&](gicube_board& handle) { render(handle, to_view(view, "view"), to_progress(progress, user)); });
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
    if (there > 0) check_count("count", count, there);  // before the transfer; without a picture the driver throws
    hand_over(handle, handle.board.read_framebuffer(), pixels, count);
  });
}

gicube_status gicube_render(gicube_board* board, const gicube_view* view, gicube_pixel* pixels, size_t count,
                            gicube_progress progress, void* user) {
  return on_board(board, [&](gicube_board& handle) {
    const gicube::View picture = to_view(view, "view");
    checked("pixels", pixels);
    if (picture.width > 0 && picture.height > 0) {  // otherwise the driver names what is wrong with them
      check_count("count", count, pixels_of({picture.width, picture.height}));
    }
    render(handle, picture, to_progress(progress, user));
    hand_over(handle, handle.board.read_framebuffer(), pixels, count);
  });
}
}

// Materials, lighting and pictures.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "encode/argument.h"
#include "encode/camera.h"
#include "encode/lights.h"
#include "encode/vectors.h"
#include "encode/volume/block_order.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/registers.h"
#include "picture_parts.h"
#include "state.h"

namespace gicube {
namespace {

namespace reg = wire::reg;

// Samples at a cut face are not shaded: they are inside the volume, where gradients are mostly noise.
std::uint32_t pipeline_word(const View& view, std::uint16_t minor) {
  const bool faces = view.shade && !view.cut_planes.empty() && minor >= wire::kCutFacesMinor;
  return (view.jitter ? wire::kPipelineJitter : 0u) | (view.shade ? wire::kPipelineShade : 0u) |
         (view.leap ? wire::kPipelineLeap : 0u) | (view.irradiance ? wire::kPipelineIrradiance : 0u) |
         (view.scatter ? wire::kPipelineScatter : 0u) | (view.high_albedo ? wire::kPipelineHighAlbedo : 0u) |
         (faces ? wire::kPipelineCutFaces : 0u);
}

LitBox lit_box(const LoadedVolume& volume) {
  const auto [x, y, z] = volume.dims;
  return {times({x - 1.0, y - 1.0, z - 1.0}, volume.relative_spacing), volume.relative_spacing};
}

// Unpacks the words of a framebuffer's part, two in nine bytes.
void take_pixels(std::span<const std::uint8_t> words, std::span<Pixel> pixels) {
  std::size_t i = 0;
  for (; i + 1 < pixels.size(); i += 2) {
    take_pixel(wire::to_pixel(wire::load36(words, i)), pixels[i]);
    take_pixel(wire::to_pixel(wire::load36(words, i + 1)), pixels[i + 1]);
  }
  if (i < pixels.size()) take_pixel(wire::to_pixel(wire::load36(words, i)), pixels[i]);
}

}  // namespace

// Brightness of a unit of power per unit of area.
double BoardState::exposure_of(const View& view) const {
  constexpr double kFull = 0.8;  // chosen: of white, for a surface in the middle of the volume
  if (view.exposure > 0) return view.exposure;
  if (!view.irradiance) return 1;
  return bright_flux > 0 ? kFull / bright_flux : 0;
}

// Brightness of a unit of irradiance, 16.16. On the wide datapath the pipeline drops the words' low 16 bits first.
std::uint32_t BoardState::exposure_word(const View& view) const {
  const double unit = irradiance_unit * (info.wide ? 65536.0 : 1.0);
  const double word = exposure_of(view) * unit * 65536;
  return static_cast<std::uint32_t>(std::clamp(std::round(word), 0.0, 4294967295.0));
}

void BoardState::check_drift(const char* field, double step) const {
  if (info.wide) return;
  const Vec3 way{volume->dims[0] - 1.0, volume->dims[1] - 1.0, volume->dims[2] - 1.0};
  if (wire::max_drift(length(way), static_cast<std::uint32_t>(std::lround(step * wire::kStepOne))) <= 1) return;
  const double shortest = 1 / (1 / wire::max_drift(length(way), wire::kStepOne) - 1);
  throw BadArgument(
      field,
      fmt::format("at least {:.3f}: in shorter steps positions drift by more than a voxel over this volume "
                  "(not with asic.datapath=wide)",
                  std::ceil(shortest * 1000) / 1000),
      number_text(step));
}

void BoardState::set_sampling(const View& view) {
  device.set_register(reg::kStep, step_word(view));
  device.set_register(reg::kOpacityThreshold,
                      static_cast<std::uint32_t>(std::lround(view.opacity_threshold * wire::kOpacityOne)));
  device.set_register(reg::kPipeline, pipeline_word(view, device.agreed().minor));
  device.set_register(reg::kLifetime, static_cast<std::uint32_t>(view.lifetime));
  device.set_register(reg::kSeed, view.seed);
  if (view.irradiance) device.set_register(reg::kExposure, exposure_word(view));
  tables.set_light(!view.irradiance ? SampleLight::kMap
                   : view.incident  ? SampleLight::kIncident
                                    : SampleLight::kAbsorbed);
  if (volume) tables.send_segmentation(volume->range);
  const auto planes = static_cast<std::uint32_t>(view.cut_planes.size());
  for (std::uint32_t i = 0; i < planes; ++i) {
    const auto words = cut_plane_words(view.cut_planes[i]);
    for (std::uint32_t w = 0; w < words.size(); ++w) device.set_register(reg::kCutPlane0 + 16 * i + 4 * w, words[w]);
  }
  device.set_register(reg::kCutPlanes, planes);
}

BoardState::BrickRun BoardState::picture_run(const View& view, const wire::RenderCommand& camera,
                                             Picoseconds deadline) {
  BrickRun run;
  run.deadline = deadline;
  if (view.irradiance) run.needs.light = LightUse::kSeen;
  run.needs.levels = block_levels;
  if (view.scatter) return run;
  if (view.leap) run.needs.leapt_over = volume->flags;
  const auto order =
      std::make_shared<BlockOrder>(bricks->blocks(), bricks->block_voxels(), camera, std::span(view.cut_planes));
  run.order = [order](std::span<const wire::WaitingBlock> waiting) { return order->reached_from(waiting); };
  return run;
}

void Renderer::render_to_framebuffer(const View& view, const Progress& progress) {
  const auto lock = state_->begin();
  state_->render(view, {}, progress);
}

void BoardState::render(const View& view, const PicturePart& picture, const Progress& progress,
                        const std::function<void()>& tables_there) {
  check(view);
  const LoadedVolume& of = loaded("rendering");
  if (view.irradiance && irradiance_unit <= 0) {
    throw Rejected("View::irradiance needs light: call illuminate() first");
  }
  if (view.scatter) {
    need_routine(false);
    need_no_routine_in_bricks("View::scatter with the application's routine", false);
  }
  const bool sees_lamps = view.scatter && !view.lamps.empty();
  if (sees_lamps && device.agreed().minor < wire::kLampsMinor) {
    throw Rejected(fmt::format("View::lamps needs a board of protocol 2.{}, this one has 2.{}", wire::kLampsMinor,
                               device.agreed().minor));
  }
  check_drift("step", view.step);
  if (shared) {
    share_anew();
    expect(shared->ranks() <= 255, "ranks", "at most 255 for a picture", shared->ranks());
  }
  const Vec3 eye = towards_eye(view, of.relative_spacing);
  std::uint32_t parts = 1;  // as the board reports them
  Progress part;
  if (progress) part = [&](std::uint32_t done, std::uint32_t all) { progress(done, parts = all); };
  const Progress told = watched(part);
  set_sampling(view);
  if (view.shade) tables.send_reflectance(eye);
  if (tables_there) {
    check_fence();
    tables_there();
  }
  wire::RenderCommand camera = viewing_command(view, of.relative_spacing);
  std::vector<wire::Lamp> lamps;
  if (sees_lamps) lamps = lamp_records(view, exposure_of(view));
  camera.lamps = static_cast<std::uint8_t>(lamps.size());
  camera.strip_rows = shared ? strip_rows(view, shared->ranks(), false) : picture.strip_rows;
  camera.part = shared ? static_cast<std::uint8_t>(shared->rank()) : picture.part;
  camera.parts = shared ? static_cast<std::uint8_t>(shared->ranks()) : picture.parts;
  std::vector<std::uint8_t> payload = wire::encoded(camera);
  for (const wire::Lamp& lamp : lamps) wire::append(payload, lamp);
  const Picoseconds last = deadline();
  BrickRun run;
  if (bricks) {
    block_levels = levels_of(view);
    run = picture_run(view, camera, last);
    bricks->set_cells(volume->dims, volume->coloured, &tables.codebook());
    bricks->clear_detail(run.needs);
    bricks->prepare(device, run.needs);
    check_fence();
  }
  CommandResult result;
  const bool has_rows = shared || wire::rows_of(camera) > 0;
  if (has_rows) result = device.run(payload, told, last);
  sampling = view;
  framebuffer_size = {};  // no picture until all rays have ended
  if (!has_rows) return;
  if (bricks) {
    run_in_bricks(result.payload, run);
  } else {
    scatter_waiting(result.payload, {});
  }
  framebuffer_size = {view.width, wire::rows_of(camera)};
  if (told) told(parts, parts);
}

Image Renderer::read_framebuffer() {
  const auto lock = state_->begin();
  return state_->shared ? state_->gather_picture() : state_->read_picture();
}

void Renderer::read_framebuffer(std::span<Pixel> pixels) {
  const auto lock = state_->begin();
  const auto [width, height] = state_->framebuffer_size;
  const auto count =
      static_cast<std::size_t>(width) * static_cast<std::size_t>(state_->shared ? state_->sampling.height : height);
  if (width > 0) expect(pixels.size() == count, "pixels", fmt::format("{}, as the picture has", count), pixels.size());
  if (!state_->shared) return state_->read_picture(pixels);
  const Image image = state_->gather_picture();
  std::ranges::copy(image.pixels, pixels.begin());
}

// Gathers the rows of all ranks.
Image BoardState::gather_picture() {
  if (framebuffer_size.first == 0) throw Rejected("read_framebuffer() needs a picture: call render() first");
  const int width = sampling.width, height = sampling.height;
  const std::uint16_t rows = strip_rows(sampling, shared->ranks(), false);
  const auto bytes_of = [](const Image& image) {
    std::vector<std::uint8_t> bytes(wire::packed36_bytes(image.pixels.size()));
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const Pixel& pixel = image.pixels[i];
      wire::store36(bytes, i, wire::to_word(wire::Pixel{pixel.red, pixel.green, pixel.blue, pixel.alpha}));
    }
    return bytes;
  };
  const auto all = gather(bytes_of(framebuffer_size.second > 0 ? read_picture() : Image{}));
  std::vector<Image> parts;
  for (std::size_t rank = 0; rank < all.size(); ++rank) {
    const wire::RenderCommand part{.height = static_cast<std::uint16_t>(height),
                                   .strip_rows = rows,
                                   .part = static_cast<std::uint8_t>(rank),
                                   .parts = static_cast<std::uint8_t>(all.size())};
    Image& image = parts.emplace_back(Image{width, wire::rows_of(part), {}});
    image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(image.height));
    if (all[rank].size() != wire::packed36_bytes(image.pixels.size())) {
      throw Error(fmt::format("RayExchange::exchange() returned {} bytes for {} rows of a picture", all[rank].size(),
                              image.height));
    }
    take_pixels(all[rank], image.pixels);
  }
  return join_rows(width, height, rows, parts);
}

Image BoardState::read_picture() {
  const auto [width, height] = framebuffer_size;
  Image image{width, height, {}};
  image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  read_picture(image.pixels);
  return image;
}

void BoardState::read_picture(std::span<Pixel> pixels) {
  if (framebuffer_size.first == 0) throw Rejected("read_framebuffer() needs a picture: call render() first");
  constexpr std::size_t kPair = 9;  // bytes of two pixels
  take_pixels(device.read_memory(wire::kFramebuffer.base, wire::packed36_bytes(pixels.size()), kPair), pixels);
}

Image Renderer::render(const View& view, const Progress& progress) {
  render_to_framebuffer(view, progress);
  return read_framebuffer();
}

Pending<Image> Renderer::start(const View& view) {
  return state_->start<Image>(
      [state = state_, view](const Progress& progress) { return Renderer(*state).render(view, progress); });
}

void LookUpTables::set_material(const Material& material, int tag) {
  const auto lock = state_->begin();
  check(material);
  expect_within("tag", tag, 0, wire::kTags - 1);
  expect(state_->info.irradiance_words > 1 || material.scattering_colour == Colour{1, 1, 1},
         "material.scattering_colour", "white on a board with one irradiance word (asic.irradiance_words is 1)",
         "another colour");
  state_->tables.set_material(material, tag);
  if (state_->volume) state_->tables.send_segmentation(state_->volume->range);  // gains depend on scattering
}

void BoardState::set_lighting(const Illumination& settings) {
  device.set_register(reg::kStep, static_cast<std::uint32_t>(std::lround(settings.step * wire::kStepOne)));
  device.set_register(reg::kPipeline,
                      (settings.jitter ? wire::kPipelineJitter : 0u) | (settings.leap ? wire::kPipelineLeap : 0u));
  device.set_register(reg::kLifetime, static_cast<std::uint32_t>(settings.lifetime));
  device.set_register(reg::kSeed, settings.seed);
  device.set_register(reg::kCutPlanes, 0);  // cut planes concern views only
}

// Sends the block that contains the light, so that the board can tell whether the light is in a solid.
void BoardState::prepare_light(const Light& light) {
  const BrickNeeds needs{.light = LightUse::kLeft};
  const auto command = light_command(light, {}, 1);
  const auto edge = to_array(volume->relative_spacing);
  Dims at{};
  bool inside = command.kind != wire::LightKind::kDirectional;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double voxels = command.position[axis];
    if (command.kind == wire::LightKind::kRectangle) voxels += (command.u[axis] + command.v[axis]) / 2 / edge[axis];
    inside = inside && voxels >= 0 && voxels <= volume->dims[axis] - 1;
    if (inside) at[axis] = static_cast<int>(voxels) / bricks->block_voxels();
  }
  if (inside) {
    const std::size_t block = index_of(volume->blocks, at);
    bricks->load(device, std::span(&block, 1), needs);
  } else {
    bricks->prepare(device, needs);
  }
  check_fence();
}

Pending<LightingReport> Illuminator::start(std::span<const Light> lights, const Illumination& settings) {
  return state_->start<LightingReport>(
      [state = state_, all = std::vector<Light>(lights.begin(), lights.end()), settings](const Progress& progress) {
        return Illuminator(*state).illuminate(all, settings, progress);
      });
}

LightingReport Illuminator::illuminate(std::span<const Light> lights, const Illumination& settings,
                                       const Progress& progress) {
  const auto lock = state_->begin();
  for (std::size_t i = 0; i < lights.size(); ++i) check(lights[i], fmt::format("lights[{}]", i));
  check(settings, lights.size(), state_->info.irradiance_words);
  const LoadedVolume& volume = state_->loaded("illuminate()");
  state_->check_drift("step", settings.step);
  state_->need_routine(true);
  state_->need_no_routine_in_bricks("illuminate() with the application's routine", true);
  const auto words = static_cast<std::size_t>(state_->info.irradiance_words);
  state_->need_colours_on_card("illuminate()");
  const LitBox box = lit_box(volume);
  LightingReport report;
  if (words > 1) report.colours.resize(words);
  report.unit = lights.empty() ? 1 : energy_unit(lights, settings, box, state_->info.wide);

  if (state_->shared) state_->share_anew();
  state_->set_lighting(settings);
  const std::uint16_t minor = state_->device.agreed().minor;
  const std::size_t ledger_bytes = words * wire::lighting_ledger_bytes(minor);
  const Picoseconds deadline = state_->deadline();
  state_->device.write_register(reg::kControl, wire::kControlClearIrradiance);
  if (state_->bricks) state_->bricks->light().clear();
  state_->irradiance_unit = report.unit;
  double flux = 0;
  std::vector<std::uint8_t> in_solid(lights.size());
  wire::LightingLedger sum;
  BoardState::BrickRun run{
      .needs = {.light = LightUse::kLeft},
      .take_ledger = [&sum](const auto& each) { wire::add(each, sum); },
      .deadline = deadline,
      .of = {.of = wire::RaysOf::kLight,
             .trace = {.type = wire::RayType::kDeposit, .rules = static_cast<wire::EnergyRules>(settings.rules)}}};
  for (std::size_t i = 0; i < lights.size(); ++i) {
    flux += flux_in_the_middle(lights[i], settings, box) * brightest_of(settings, i);
    if (state_->shared && i % state_->shared->ranks() != static_cast<std::size_t>(state_->shared->rank())) {
      state_->run_waiting({}, run);
      continue;
    }
    const auto all = static_cast<std::uint32_t>(lights.size()), before = static_cast<std::uint32_t>(i);
    Progress part;
    if (progress) {  // each light is an equal part of the progress
      part = [&progress, all, before](std::uint32_t done, std::uint32_t of) {
        constexpr std::uint32_t kParts = 1000;
        const std::uint32_t here = of > 0 ? static_cast<std::uint32_t>(std::uint64_t{kParts} * done / of) : 0;
        progress(before * kParts + here, all * kParts);
      };
    }
    const Progress told = state_->watched(part);
    if (state_->bricks) state_->prepare_light(lights[i]);
    if (words > 1) {
      const auto colour = light_colour_words(settings, i);
      for (std::uint32_t c = 0; c < 3; ++c) state_->device.set_register(reg::kLightRed + 4 * c, colour[c]);
    }
    const CommandResult result = state_->device.run(
        wire::encoded(light_command(lights[i], settings, report.unit / brightest_of(settings, i))), told, deadline);
    const std::span<const std::uint8_t> payload = result.payload;
    if (payload.size() < ledger_bytes) state_->device.give_up("a lighting result of wrong size");
    const auto ledger = wire::decode_lighting_ledger(payload, minor);
    for (std::size_t word = 1; word < words; ++word) {
      add(wire::decode_lighting_ledger(payload.subspan(word * ledger_bytes / words), minor), report, word);
    }
    if (state_->bricks) {
      state_->run_in_bricks(payload, run);
    } else {
      wire::add(ledger, sum);
      state_->scatter_waiting(payload.subspan(ledger_bytes), [&sum](wire::LightingLedger resumed) {
        resumed.emitted = 0;  // counted when the rays were made
        wire::add(resumed, sum);
      });
    }
    in_solid[i] = ledger.light_in_solid != 0 ? 1 : 0;
    if (told) told(1, 1);
  }
  if (state_->shared) {
    state_->end_shared_light(sum);
    for (const auto& of_rank : state_->gather(in_solid)) {
      for (std::size_t i = 0; i < std::min(of_rank.size(), in_solid.size()); ++i) in_solid[i] |= of_rank[i];
    }
  }
  add(sum, report);
  report.warnings = state_->tables.light_warnings(settings.albedo, settings.rules, settings.step);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (in_solid[i] != 0) report.warnings.push_back(fmt::format("lights[{}] is in a solid: its light stays there", i));
  }
  state_->bright_flux = flux;
  if (report.clipped > 0.01 * report.emitted) {
    report.warnings.push_back("more than 1% of the energy was clipped by saturated irradiance words");
  }
  if (settings.albedo == Albedo::kLow && settings.rules == EnergyRules::kAsPrinted &&
      report.scattered_away > 0.01 * report.emitted) {
    report.warnings.push_back("the printed rules of low albedo lost the energy that was scattered");
  }
  return report;
}

}  // namespace gicube

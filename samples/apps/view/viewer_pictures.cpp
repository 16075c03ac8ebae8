// The viewer's boards, and their pictures for the pages.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "gicube/scene/error.h"
#include "gicube/scene/image_file.h"
#include "gicube/scene/transfer_function_file.h"
#include "scene/program/run_json.h"
#include "scene/program/scene_input.h"
#include "view/folder.h"
#include "view/protocol.h"
#include "view/slices.h"
#include "view/viewer.h"

namespace gicube::samples::view {
namespace {

using Json = nlohmann::ordered_json;

double rays_of(const View& view) {
  return double(view.width) * view.height * view.samples_per_axis * view.samples_per_axis;
}

// The text of the named transfer function, or of the automatic one; empty: there is none.
std::string function_of(const RenderOptions& options, const SceneSetup& setup) {
  if (options.transfer_function.empty() || options.transfer_function == kAutomatic)
    return setup.look_why.empty() || !setup.labels.empty() ? "" : tf_text(setup.materials.front());
  const auto preset = std::ranges::find(presets(), options.transfer_function, &Preset::name);
  return preset != std::ranges::end(presets()) ? std::string(preset->text) : bytes_of(options.transfer_function);
}

}  // namespace

Viewer::Desk Viewer::make_desk(const RenderOptions& options) {
  Desk made;
  made.uri = board_uri(options.board);
  made.renderer = std::make_unique<Renderer>(
      options, [this](const std::string& what) { return step(what); }, [this] { stop_if_told(); });
  return made;
}

void Viewer::serve(Desk& desk, const RenderOptions& options) {
  desk.renderer->change(options);
  // A board accepts a world's own codebook of normals only once.
  const bool is_world = desk.renderer->input().world && desk.renderer->loaded();
  if (is_world && !desk.renderer->holds(options.animation.start.value_or(0))) {
    desk = {};
    desk = make_desk(options);
  }
}

Renderer& Viewer::volume_renderer() {
  for (const Desk* desk : {&quick_, &main_}) {
    if (desk->renderer && desk->renderer->loaded()) return *desk->renderer;
  }
  const RenderOptions options = options_of(chosen_, shelf_, options_.board);
  Renderer& renderer = *quick_desk(options).renderer;
  renderer.prepare(options.animation.start.value_or(0));
  return renderer;
}

Viewer::Desk& Viewer::desk(const RenderOptions& options) {
  const std::string uri = board_uri(options.board);
  const bool is_quick = quick_.renderer && quick_.uri == uri;  // of another page with another level
  Desk& found = is_quick && main_.uri != uri ? quick_ : main_;
  if (found.renderer && found.uri == uri) {
    serve(found, options);
  } else {
    found = {};
    found = make_desk(options);
  }
  live_.show(found.uri, found.renderer->board().info().config_hash);
  return found;
}

Viewer::Desk& Viewer::quick_desk(const RenderOptions& options) {
  Desk& asked = desk(options);
  if (asked.renderer->board().info().fidelity == Fidelity::kFunctional) return asked;
  RenderOptions quick = options;
  if (!quick.board.board.starts_with("emu:")) {
    quick.board.board = "emu:";
    quick.board.settings = {fmt::format("asic.max_volume_voxels={}", asked.renderer->board().info().max_volume_voxels)};
  }
  quick.board.set_level("functional");
  if (quick_.renderer && quick_.uri == board_uri(quick.board)) {
    serve(quick_, quick);
  } else {
    quick_ = {};
    quick_ = make_desk(quick);
  }
  return quick_;
}

Frame Viewer::render(Desk& desk, const RenderOptions& options) {
  serve(desk, options);
  const Frame frame = desk.renderer->picture(options.animation.start.value_or(0));
  live_.counted({desk.renderer->board().now(), desk.renderer->board().counters()});
  const View& view = desk.renderer->setup().view;
  desk.ray_seconds = frame.statistics.host_seconds * view.step / rays_of(view);
  return frame;
}

void Viewer::picture(const Job& job) {
  const auto input = job.request->settings.find("input");
  if (input != job.request->settings.end() && input->second != input_) open_input(input->second);
  const Settings settings = completed(job.request->settings);
  const RenderOptions options = options_of(settings, shelf_, options_.board);
  Desk& quick = quick_desk(options);
  const bool is_same = quick.uri == board_uri(options.board);
  quick.renderer->prepare(options.animation.start.value_or(0));
  const View& view = quick.renderer->setup().view;
  // An unknown host time of the whole picture counts as too long.
  const double budget = std::chrono::duration<double>(kFrameBudget).count();
  const double seconds = quick.ray_seconds * rays_of(view) / view.step;
  const bool fits = is_same && quick.ray_seconds > 0 && seconds <= budget;
  if (!fits) {
    // Steps are doubled first, which is least visible; then pixels are reduced.
    double share = quick.ray_seconds > 0 ? budget / seconds : 1.0 / 16;
    RenderOptions coarse = options;
    coarse.samples = 1;
    share *= view.samples_per_axis * view.samples_per_axis;
    if (share < 1 && view.step <= 1) coarse.step = 2 * view.step, share *= 2;
    const double scale = std::clamp(std::sqrt(share), 1.0 / 16, 1.0);
    const auto scaled = [scale](int pixels) { return std::max(1, static_cast<int>(std::lround(scale * pixels))); };
    coarse.size = {scaled(view.width), scaled(view.height)};
    send_picture(job, quick, coarse, settings, false);
    if (job.request->on) return;
  }
  stop_if_told();
  send_picture(job, desk(options), options, settings, true);
  if (job.request->projection == Request::Projection::kNone) return;
  stop_if_told();
  Renderer& renderer = *quick_desk(options).renderer;
  renderer.prepare(options.animation.start.value_or(0));
  if (renderer.input().world || !renderer.setup().labels.empty()) return;
  const auto progress = [this, told = step("projecting")](std::uint32_t done, std::uint32_t all) {
    stop_if_told();
    told(done, all);
  };
  const Slice seen = projection_of(renderer.board(), renderer.setup(), job.request->projection, progress);
  tell(job.page, {{"type", "projection"}, {"id", job.request->id}, {"width", seen.width}, {"height", seen.height}},
       seen.words, "projection");
}

void Viewer::send_picture(const Job& job, Desk& desk, const RenderOptions& options, const Settings& settings,
                          bool whole) {
  const Frame frame = render(desk, options);
  std::vector<std::uint8_t> pixels = png_pixels(frame.image, frame.background);
  if (frame.background) {
    std::vector<std::uint8_t> opaque;
    opaque.reserve(frame.image.pixels.size() * 4);
    for (std::size_t i = 0; i < pixels.size(); i += 3)
      opaque.insert(opaque.end(), {pixels[i], pixels[i + 1], pixels[i + 2], 255});
    pixels = std::move(opaque);
  }
  const FrameStatistics& statistics = frame.statistics;
  const bool timed = statistics.board.fidelity != Fidelity::kFunctional;
  Json header{{"type", "picture"},
              {"id", job.request->id},
              {"width", frame.image.width},
              {"height", frame.image.height},
              {"final", whole},
              {"frame_ms", timed ? Json(to_ms(statistics.frame)) : Json(nullptr)},
              {"level", gicube::name_of(statistics.board.fidelity)},
              {"host_ms", 1e3 * statistics.host_seconds}};
  if (!statistics.invisible.empty()) header["invisible"] = statistics.invisible;
  if (whole) {
    const std::string command = command_of(settings, shelf_, options_.board);
    header["command"] = command;
    Provenance provenance = provenance_of(statistics.board, statistics.scene_hash);
    provenance.command = command;
    const std::string python = python_of(settings, shelf_, options, desk.renderer->setup(), frame.background);
    if (!python.empty()) header["python"] = python;
    Made made{frame.image, frame.background, to_json(statistics).dump(2) + '\n',
              function_of(options, desk.renderer->setup()), provenance};
    const std::lock_guard lock(mutex_);
    header["number"] = ++last_number_;
    made_.emplace(last_number_, std::move(made));
    if (made_.size() > kMaxMade) made_.erase(made_.begin());
  }
  tell(job.page, header, pixels, "picture");
}

void Viewer::compare(const Job& job) {
  Json message{{"type", "compared"}, {"id", job.request->id}};
  std::vector<Image> images;
  for (const Settings* settings : {&job.request->settings, &job.request->other}) {
    const RenderOptions options = options_of(completed(*settings), shelf_, options_.board);
    Desk desk = make_desk(options);
    live_.show(desk.uri, desk.renderer->board().info().config_hash);
    const Frame frame = desk.renderer->picture(options.animation.start.value_or(0));
    const bool timed = frame.statistics.board.fidelity != Fidelity::kFunctional;
    Json counters = Json::object();
    for (const Counter& counter : frame.statistics.counters.list()) counters[counter.name] = counter.value;
    message["frames"].push_back({{"frame_ms", timed ? Json(to_ms(frame.statistics.frame)) : Json(nullptr)},
                                 {"settings", *settings},
                                 {"counters", counters}});
    images.push_back(frame.image);
  }
  message["same"] = images[0] == images[1];
  tell(job.page, message);
}

void Viewer::slice(const Job& job) {
  const Request& request = *job.request;
  Renderer& renderer = volume_renderer();
  const Slice slice = slice_of(renderer.board(), renderer.setup(), request);
  const auto axis = static_cast<std::size_t>(request.axis);
  const Json header{{"type", "slice"},  {"id", request.id},     {"axis", std::string(1, "xyz"[axis])},
                    {"at", request.at}, {"width", slice.width}, {"height", slice.height}};
  tell(job.page, header, slice.words, std::string("slice ") + "xyz"[axis]);
}

void Viewer::histogram(Page page) {
  Board& board = volume_renderer().board();
  const Dims dims = board.dims();
  const ValueRange range = board.value_range();
  constexpr std::size_t kBins = 256;
  std::vector<std::uint64_t> counts(kBins);
  const double scale = range.high > range.low ? kBins / (range.high - range.low) : 0;
  constexpr int kSlab = 32;  // chosen: 8 MB of a 256^3 volume at once
  for (int z = 0; z < dims[2]; z += kSlab) {
    const VoxelBox box{{0, 0, z}, {dims[0], dims[1], std::min(kSlab, dims[2] - z)}};
    for (const float value : board.read_volume(box)) {
      const double bin = (double{value} - range.low) * scale;
      ++counts[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))];
    }
  }
  tell(page, {{"type", "histogram"}, {"low", range.low}, {"high", range.high}, {"counts", counts}});
}

std::optional<Viewer::Download> Viewer::download(const std::string& what, std::uint64_t number) {
  std::optional<Made> made;
  {
    const std::lock_guard lock(mutex_);
    const auto found = made_.find(number);
    if (found != made_.end()) made = found->second;
  }
  if (!made) return std::nullopt;
  if (what == "stats") return Download{"picture.json", "application/json", made->statistics};
  if (what == "tf" && !made->function.empty()) return Download{"view.tf", "text/plain", made->function};
  if (what != "png" && what != "exr") return std::nullopt;
  const std::filesystem::path file = options_.folder / (".picture." + what);
  write_image(made->image, file, what == "png" ? made->background : std::nullopt, made->provenance);
  return Download{"picture." + what, what == "png" ? "image/png" : "image/x-exr", bytes_of(file)};
}

}  // namespace gicube::samples::view

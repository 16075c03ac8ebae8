#include "studies/results/measure.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <numbers>
#include <stdexcept>

#include "gicube/scene/image_file.h"
#include "scene/program/board_run.h"

namespace gicube::samples::results {
namespace {

Board board_for(const Run& run) {
  BoardOptions options;
  options.fidelity = "cycle";
  options.threads = 1;
  for (const auto& [field, value] : run.settings) options.settings.push_back(field + '=' + value);
  return samples::open_board(options);
}

void load(Board& board, const SceneData& scene, bool be_faint) {
  board.set_shading(scene.shading);
  if (scene.codebook.size() > 1) board.set_gradient_codebook(scene.codebook);
  board.load_volume(scene.volume_view());
  for (std::size_t tag = 0; tag < scene.materials.size(); ++tag) {
    const TransferFunction& function = scene.materials[tag].function;  // in densities
    board.set_transfer_function(be_faint ? faint(function) : function, static_cast<int>(tag));
  }
  for (std::size_t tag = 0; tag < scene.optics.size(); ++tag) {
    board.set_material(scene.optics[tag], static_cast<int>(tag));
  }
}

View view_of(const Run& run, const SceneData& scene) {
  View view = make_view(scene, run.view, run.width, run.height, run.orthographic);
  view.step = run.step;
  view.opacity_threshold = 0.98;
  view.leap = run.leap;
  view.jitter = run.jitter;
  view.irradiance = run.light_rays > 0;
  view.scatter = !scene.optics.empty();
  return view;
}

// What `work` adds to the board's counters and clock.
template <typename Work>
Json window(Board& board, const Work& work) {
  RunWindow run(board);
  work();
  Json result{{"time_ps", run.simulated()}};
  const Counters added = run.counters();
  for (const Counter& counter : added.list()) result["counters"][counter.name] = counter.value;
  result["processors"] = board.info().processors;
  result["core_hz"] = 1e3 * board.info().core_khz;
  return result;
}

LightingReport illuminate(Board& board, const Run& run, const SceneData& scene) {
  Illumination settings = scene.lighting.settings;
  settings.rays_per_face_voxel = run.light_rays;
  settings.albedo = run.high_albedo ? Albedo::kHigh : Albedo::kLow;
  settings.step = run.step;
  settings.leap = run.leap;
  settings.jitter = run.jitter;
  return board.illuminate(scene.lights, settings);
}

// The view's rays, from where they enter the volume; those that miss it are left out.
std::vector<HostRay> rays_of(const View& view, const Dims& dims) {
  const Vec3 forward = normalise(view.look_at - view.eye), right = normalise(cross(forward, view.up));
  const Vec3 up = cross(right, forward);
  const double tangent = std::tan(view.fov_degrees * std::numbers::pi / 360);
  std::vector<HostRay> rays;
  for (int v = 0; v < view.height; ++v) {
    for (int u = 0; u < view.width; ++u) {
      const double x = tangent * (2 * (u + 0.5) - view.width) / view.height;
      const double y = tangent * (view.height - 2 * (v + 0.5)) / view.height;
      const Vec3 direction = normalise(forward + x * right + y * up);
      double near = 0, far = 1e9;
      const auto clip = [&](double eye, double along, int size) {
        const double a = (0 - eye) / along, b = (size - 1 - eye) / along;
        near = std::max(near, std::min(a, b)), far = std::min(far, std::max(a, b));
      };
      clip(view.eye.x, direction.x, dims[0]);
      clip(view.eye.y, direction.y, dims[1]);
      clip(view.eye.z, direction.z, dims[2]);
      if (!(near < far)) continue;
      const Vec3 p = view.eye + near * direction;
      const auto inside = [](double a, int size) { return std::clamp(a, 0.0, size - 1.0); };
      rays.push_back({static_cast<std::uint32_t>(v * view.width + u),
                      {inside(p.x, dims[0]), inside(p.y, dims[1]), inside(p.z, dims[2])},
                      direction});
    }
  }
  return rays;
}

// The rest of the pipeline is set up as for the last view. This one looks past the volume: no ray of it goes to the ASIC.
void set_pipeline(Board& board, View view) {
  view.width = view.height = 1;
  view.look_at = 2.0 * view.eye - view.look_at;
  board.render_to_framebuffer(view);
}

// Host rays, sampled as the view is.
Json trace(Board& board, const View& view, const std::vector<HostRay>& rays) {
  set_pipeline(board, view);
  return window(board, [&] { board.receive(board.submit(rays, {.step = view.step, .leap = view.leap})); });
}

Json fill_block(Board& board, View view) {
  const int n = board.info().block_voxels;
  view.cut_planes = {{{0, 0, -1}, -double(n)}};
  view.shade = false;
  std::vector<HostRay> rays;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x)
      rays.push_back({static_cast<std::uint32_t>(rays.size()), {x + 0.5, y + 0.5, 0.5 * view.step}, {0, 0, 1}});
  }
  return trace(board, view, rays);
}

// `lit`: an illumination pass has been there.
Json measure(Board& board, const Run& run, const SceneData& scene, bool& lit) {
  const View view = view_of(run, scene);
  if (run.kind == "frame" && run.light_rays > 0 && !lit) illuminate(board, run, scene);
  lit = run.light_rays > 0;
  if (run.kind == "light") {
    LightingReport report;
    Json result = window(board, [&] { report = illuminate(board, run, scene); });
    result["clipped"] = report.emitted == 0 ? 0 : report.clipped / report.emitted;
    return result;
  }
  if (run.kind == "host_rays") return trace(board, view, rays_of(view, scene.volume.dims));
  if (run.kind == "fill_block") return fill_block(board, view);
  Image image;
  Json result = window(board, [&] { image = board.render(view); });
  if (!run.picture.empty()) write_png(image, run.picture, background_of(run.scene));
  return result;
}

}  // namespace

std::shared_ptr<const SceneData> SceneStore::get(const Run& run) {
  constexpr int kThreads = 2;  // chosen: the other worker most often waits for the same scene
  const auto make = [run] {
    return std::make_shared<const SceneData>(make_scene(run.scene, run.dims, run.edge, kThreads));
  };
  std::unique_lock lock(mutex_);
  Future& place = scenes_[{run.scene, run.dims, run.edge}];
  if (!place.valid()) place = std::async(std::launch::deferred, make);
  const Future future = place;
  lock.unlock();
  return future.get();
}

void measure(const std::vector<Run>& runs, SceneStore& scenes, const std::function<void(std::size_t, Json)>& keep) {
  std::size_t at = 0;
  try {
    const std::shared_ptr<const SceneData> scene = scenes.get(runs.front());
    Board board = board_for(runs.front());
    load(board, *scene, runs.front().faint);
    bool lit = false;
    for (; at < runs.size(); ++at) keep(at, measure(board, runs[at], *scene, lit));
  } catch (const std::exception& error) {
    throw std::runtime_error(runs[at].name + ": " + error.what());
  }
}

}  // namespace gicube::samples::results

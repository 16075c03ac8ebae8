#include "compose/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>

#include "scene/common/checks.h"
#include "scene/program/board_run.h"

namespace gicube::samples {
namespace {

constexpr std::size_t kBatch = 1 << 16;  // chosen: segments of one submit()
constexpr std::size_t kUnderWay = 4;     // chosen: batches; the board works on while the host makes the next

Vec3 times(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

Vec3 clamped(Vec3 p, const Dims& dims) {
  return {std::clamp(p.x, 0.0, dims[0] - 1.0), std::clamp(p.y, 0.0, dims[1] - 1.0),
          std::clamp(p.z, 0.0, dims[2] - 1.0)};
}

// Maps the volume's voxels to the space that it is placed in.
Affine own_space(const SceneSetup& setup, bool world) {
  if (!world) return scan_space(setup.volume);
  const double voxel = setup.grid.voxel;
  return compose(translation(setup.grid.low), scaling({voxel, voxel, voxel}));
}

void place(const PlacedVolume& placed, StageMedium& medium) {
  const Affine map = compose(placed.to_space, own_space(medium.setup, placed.scene.world.has_value()));
  require(std::abs(determinant(map)) > std::numeric_limits<double>::min(), "transform", "one that keeps a volume",
          determinant(map));
  medium.to_voxels = inverse(map);
}

// The mesh's normals give the light, because the volume's axes turn from place to place.
void place(const PlacedShell& placed, StageMedium& medium) {
  medium.setup.view.shade = false;
  medium.shell = std::make_shared<const Shell>(placed.mesh, placed.settings, medium.setup.volume.dims);
}

template <typename Placed>
StageMedium set_up(const Placed& placed, int threads) {
  StageMedium medium{placed.name, {}, {}};
  try {
    medium.setup = set_up(placed.scene, threads);
    place(placed, medium);
  } catch (const FileError&) {
    throw;
  } catch (const InputError& error) {
    throw InputError(within(placed.name, error));
  }
  return medium;
}

void include(SceneBox& box, Vec3 p) {
  box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
  box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
}

// The box for the default camera.
SceneBox box_of(const Stage& stage) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  SceneBox box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (const StageMedium& medium : stage.media) {
    if (medium.shell) {
      for (const Vec3& p : medium.shell->faces().points) include(box, p);
      continue;
    }
    const Affine to_space = inverse(medium.to_voxels);
    const auto& [low, high] = medium.setup.box;
    for (int i = 0; i < 8; ++i) {
      const Vec3 corner{(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y, (i & 4) != 0 ? high.z : low.z};
      include(box, to_space.point(corner));
    }
  }
  for (const Mesh& mesh : stage.meshes->meshes()) {
    for (const Vec3& p : mesh.points) include(box, p);
  }
  return box;
}

// Shades both sides equally, without highlights.
Premultiplied shaded(const Stage& stage, const Crossing& crossing) {
  const PlacedSurface& surface = stage.surfaces[crossing.mesh];
  const double facing = std::abs(dot(stage.meshes->normal(crossing), normalise(stage.light)));
  const double shade = stage.phong.ambient + stage.phong.diffuse * facing;
  Premultiplied look{{}, surface.opacity};
  for (std::size_t c = 0; c < 3; ++c) look.colour[c] = surface.opacity * std::min(shade * surface.colour[c], 1.0);
  return look;
}

// Calls each(x, y) for the image points of all rays, by pixels.
template <typename Each>
void each_sample(const View& view, const Each& each) {
  const int n = view.samples_per_axis;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      for (int i = 0; i < n * n; ++i) each(x + (i % n + 0.5) / n, y + (i / n + 0.5) / n);
    }
  }
}

struct Result {
  std::array<float, 3> colour{};  // holds the words of both datapaths exactly
  float opacity = 0;
};

// Sends rays in batches and keeps their results in order.
class Tracer {
 public:
  Tracer(Board& board, const View& view, const StageMedium& medium)
      : board_(board),
        request_{.type = RayType::kSegment,
                 .opacity = view.opacity_threshold,
                 .step = view.step,
                 .sampling = {.shade = medium.setup.view.shade,
                              .looking = medium.to_voxels.vector(view.look_at - view.eye)}} {}

  void add(const PlannedSegment& segment, const Dims& dims) {
    rays_.push_back(
        ray_between(static_cast<std::uint32_t>(rays_.size()), clamped(segment.from, dims), clamped(segment.to, dims)));
    if (rays_.size() == kBatch) send();
  }
  std::vector<Result> finish() {
    if (!rays_.empty()) send();
    receive_down_to(0);
    return std::move(results_);
  }

 private:
  void send() {
    receive_down_to(kUnderWay - 1);
    under_way_.push_back(board_.submit(rays_, request_));
    rays_.clear();
  }
  void receive_down_to(std::size_t left) {
    for (; under_way_.size() > left; under_way_.pop_front()) {
      for (const TracedRay& ray : board_.receive(under_way_.front()).rays) {
        Result& result = results_.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) result.colour[c] = static_cast<float>(ray.colour[c]);
        result.opacity = static_cast<float>(ray.opacity);
      }
    }
  }

  Board& board_;
  RayRequest request_;
  std::vector<HostRay> rays_;
  std::deque<Ticket> under_way_;
  std::vector<Result> results_;
};

std::vector<Result> trace(const Stage& stage, std::size_t index, Board& board, MediumCost& cost) {
  const StageMedium& medium = stage.media[index];
  check_renders(medium.setup.volume.dims, board.info(), medium.setup.volume.source);
  const Picoseconds begin = board.now();
  load(board, medium.setup, false);
  board.set_shading({stage.phong, times(medium.setup.volume.spacing, medium.to_voxels.vector(stage.light))});
  const Picoseconds loaded = board.now();
  Tracer tracer(board, stage.view, medium);
  RayPlan plan;
  each_sample(stage.view, [&](double x, double y) {
    plan_ray(stage, eye_ray(stage.view, x, y), plan);
    bool met = false;
    for (const PlannedSegment& segment : plan.segments) {
      if (segment.volume != index) continue;
      tracer.add(segment, medium.setup.volume.dims);
      met = true;
    }
    cost.rays += met ? 1 : 0;
  });
  std::vector<Result> results = tracer.finish();
  cost.segments = results.size();
  cost.load = loaded - begin;
  cost.trace = board.now() - loaded;
  return results;
}

// Checks the memory before tracing.
void check_segments(const Stage& stage) {
  std::uint64_t segments = 0;
  RayPlan plan;
  each_sample(stage.view, [&](double x, double y) {
    plan_ray(stage, eye_ray(stage.view, x, y), plan);
    segments += plan.segments.size();
  });
  if (segments <= kMaxSegments) return;
  throw InputError("image, overlap_step", fmt::format("at most {} segments in all", kMaxSegments),
                   fmt::format("{}: fewer pixels, or longer steps", segments));
}

}  // namespace

Stage set_up(const Composition& composition, int threads) {
  Stage stage;
  for (const PlacedVolume& volume : composition.volumes) {
    stage.media.push_back(set_up(volume, threads));
  }
  for (const PlacedShell& shell : composition.shells) stage.media.push_back(set_up(shell, threads));
  std::vector<Mesh> meshes;
  for (const PlacedSurface& surface : composition.surfaces) {
    stage.surfaces.push_back({surface.name, {}, surface.colour, surface.opacity});
    meshes.push_back(surface.mesh);
  }
  stage.meshes = std::make_shared<const MeshCaster>(std::move(meshes));
  stage.view = composition.view;
  stage.phong = composition.phong;
  stage.overlap_step = composition.overlap_step;
  fit_camera(composition.camera, box_of(stage), {1, 1, 1}, stage.view);
  stage.light = composition.light.value_or(shoulder_light(stage.view, {1, 1, 1}));
  return stage;
}

EyeRay eye_ray(const View& view, double x, double y) {
  const Vec3 forward = normalise(view.look_at - view.eye), right = normalise(cross(forward, view.up));
  const Vec3 up = cross(right, forward);
  const bool parallel = view.orthographic_height > 0;
  const double height = parallel ? view.orthographic_height : 2 * std::tan(view.fov_degrees * std::numbers::pi / 360);
  const double pixel = height / view.height;
  const Vec3 aside = pixel * (x - 0.5 * view.width) * right + pixel * (0.5 * view.height - y) * up;
  if (parallel) return {view.eye + aside, forward};
  return {view.eye, normalise(forward + aside)};
}

void plan_ray(const Stage& stage, const EyeRay& ray, RayPlan& plan) {
  thread_local std::vector<Span> spans;
  thread_local std::vector<Crossing> crossings;
  thread_local std::vector<SurfacePoint> surfaces;
  spans.clear(), surfaces.clear();
  for (std::size_t i = 0; i < stage.media.size(); ++i) {
    const StageMedium& medium = stage.media[i];
    if (medium.shell) {
      medium.shell->add_spans(ray.origin, ray.direction, i, normalise(stage.light), stage.phong, spans);
      continue;
    }
    Span span{i, 0, 0, medium.to_voxels.point(ray.origin), medium.to_voxels.vector(ray.direction)};
    const HostRay whole{.id = 0,
                        .position = span.origin,
                        .direction = span.direction,
                        .length = std::numeric_limits<double>::infinity()};
    const auto part = clip_to_volume(whole, medium.setup.volume.dims);
    if (!part) continue;
    const double voxels = length(span.direction);
    span.near = std::max(0.0, dot(part->position - span.origin, span.direction) / (voxels * voxels));
    span.far = span.near + part->length / voxels;
    spans.push_back(span);
  }
  stage.meshes->find(ray.origin, ray.direction, crossings);
  for (const Crossing& crossing : crossings) surfaces.push_back({crossing.distance, shaded(stage, crossing)});
  plan_ray(spans, surfaces, stage.overlap_step, plan);
}

Image Picture::image() const {
  Image image{width, height, {}};
  const auto word = [](double value, int one) { return std::lround(std::clamp(value, 0.0, 1.0) * one); };
  for (const Premultiplied& pixel : pixels) {
    image.pixels.push_back(
        {static_cast<std::uint8_t>(word(pixel.colour[0], 255)), static_cast<std::uint8_t>(word(pixel.colour[1], 255)),
         static_cast<std::uint8_t>(word(pixel.colour[2], 255)), static_cast<std::uint16_t>(word(pixel.opacity, 4095))});
  }
  return image;
}

Picture compose(const Stage& stage, std::vector<Board>& boards, std::vector<MediumCost>& costs, const Progress& told) {
  check_segments(stage);
  std::vector<std::vector<Result>> results;
  costs.clear();
  for (std::size_t i = 0; i < stage.media.size(); ++i) {
    if (told) told(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(stage.media.size()));
    costs.push_back({.board = i % boards.size()});
    results.push_back(trace(stage, i, boards[costs[i].board], costs[i]));
  }

  Picture picture{stage.view.width, stage.view.height, {}};
  std::vector<std::size_t> next(stage.media.size());
  std::vector<Premultiplied> media;
  RayPlan plan;
  const auto samples = static_cast<std::size_t>(stage.view.samples_per_axis * stage.view.samples_per_axis);
  std::size_t sample = 0;
  each_sample(stage.view, [&](double x, double y) {
    plan_ray(stage, eye_ray(stage.view, x, y), plan);
    Premultiplied ray;
    auto segment = plan.segments.begin();
    for (const Layer& layer : plan.layers) {
      media.clear();
      for (std::size_t i = 0; i < layer.segments; ++i, ++segment) {
        const Result& result = results[segment->volume][next[segment->volume]++];
        media.push_back({{}, result.opacity});
        for (std::size_t c = 0; c < 3; ++c) media.back().colour[c] = segment->shade * result.colour[c];
      }
      ray = over(ray, layer.segments > 0 ? mixed(media) : layer.surface);
    }
    if (sample++ % samples == 0) picture.pixels.emplace_back();
    Premultiplied& pixel = picture.pixels.back();
    for (std::size_t c = 0; c < 3; ++c) pixel.colour[c] += ray.colour[c] / static_cast<double>(samples);
    pixel.opacity += ray.opacity / static_cast<double>(samples);
  });
  return picture;
}

}  // namespace gicube::samples

#include "studies/results/scenes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <utility>

#include "scene/buckyball.h"
#include "scene/parallel.h"
#include "studies/results/lit_scenes.h"
#include "studies/results/noise.h"

namespace gicube::samples::results {
namespace {

constexpr double kMaxDensity = 4095;     // of kUint12
constexpr int kMaxGradientVoxels = 256;  // an edge: beyond it 12 bytes a voxel of normals cost too much memory
constexpr double kFaint = 0.003;         // chosen: 443 voxels of opacity 0.003 let a quarter through
constexpr double kDesignEdge = 256;      // voxels: opacities below are those of a volume of this edge

// density(x, y, z) is 0..1.
using Density = std::function<double(Vec3)>;

Volume voxelise(const Dims& dims, const Density& density, int threads) {
  Volume volume;
  volume.type = SampleType::kUint12;
  volume.dims = dims;
  volume.source = "built in";
  const auto across = static_cast<std::size_t>(dims[0]), down = static_cast<std::size_t>(dims[1]);
  volume.samples.resize(across * down * static_cast<std::size_t>(dims[2]) * 2);
  in_parallel(static_cast<std::size_t>(dims[2]), threads, [&](std::size_t z) {
    std::size_t at = z * across * down;
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x, ++at) {
        const double value = std::clamp(density({double(x), double(y), double(z)}), 0.0, 1.0);
        const auto word = static_cast<std::uint16_t>(std::lround(kMaxDensity * value));
        std::memcpy(&volume.samples[2 * at], &word, sizeof word);
      }
    }
  });
  return volume;
}

// The opacity of a voxel of a volume of `edge`, so that the whole looks the same at every size.
double of_edge(double opacity, int edge) { return 1 - std::pow(1 - opacity, kDesignEdge / edge); }

SceneData make_ball(const Dims& dims, int threads) {
  SceneData scene;
  Buckyball ball = make_buckyball(dims[0], dims[0] <= kMaxGradientVoxels, threads);
  scene.volume = std::move(ball.volume);
  scene.tags = std::move(ball.tags);
  scene.gradients = std::move(ball.gradients);
  const Appearance look = buckyball_appearance(dims[0]);
  for (const TransferFunctionFile& material : look.materials) {
    scene.looks.push_back(in_values_of({0, kMaxDensity}, material));
  }
  scene.shading = {look.phong, *look.light};
  scene.camera = look.camera;
  return scene;
}

SceneData make_head(const Dims& dims, int edge, int threads) {
  const Vec3 half{0.5 * (dims[0] - 1), 0.5 * (dims[1] - 1), 0.5 * (dims[2] - 1)};
  const double lattice = edge / 16.0;
  SceneData scene;
  scene.volume = voxelise(
      dims,
      [&](Vec3 p) {
        // 1 on an ellipsoid that almost touches the volume's faces; the radius is rough by a few hundredths.
        const Vec3 q{(p.x - half.x) / (0.76 * half.x), (p.y - half.y) / (0.92 * half.y),
                     (p.z - half.z) / (0.88 * half.z)};
        const double radius = length(q);
        if (radius > 1.05) return 0.0;
        const double rough = cloudy_noise((1 / lattice) * p) - 0.5;
        const double shell = radius + 0.06 * rough;
        const auto step = [](double from, double to, double r) {
          return std::clamp((r - from) / (to - from), 0.0, 1.0);
        };
        const double skin = 0.3 * (1 - step(0.96, 0.985, shell)), skull = 0.6 * (1 - step(0.87, 0.89, shell));
        const double brain =
            -0.5 * (1 - step(0.79, 0.81, shell)) + 0.25 * (1 - step(0.76, 0.79, shell)) * (0.5 + rough);
        return skin + skull + brain;
      },
      threads);
  // Skin that shows the skull, bone that shows a little of the brain.
  const double skin = of_edge(0.02, edge), bone = of_edge(0.12, edge), brain = of_edge(0.05, edge);
  scene.looks = {
      {{{0, {0.8, 0.6, 0.5}}, {1300, {0.85, 0.65, 0.55}}, {1800, {0.7, 0.45, 0.45}}, {3000, {0.95, 0.92, 0.85}}},
       {{200, 0}, {900, skin}, {1400, skin}, {1800, brain}, {2300, brain}, {3000, bone}}}};
  return scene;
}

// Noise from end to end: no block is empty.
SceneData make_noise(const Dims& dims, int edge, double low, double high, Colour dark, Colour light, int threads) {
  const double lattice = edge / 8.0;
  SceneData scene;
  scene.volume = voxelise(
      dims, [&](Vec3 p) { return 0.1 + 0.8 * cloudy_noise((1 / lattice) * p); }, threads);
  scene.looks = {{{{1000, dark}, {3000, light}}, {{1000, of_edge(low, edge)}, {3000, of_edge(high, edge)}}}};
  return scene;
}

// Towards the eye.
Vec3 direction_of(ViewName view) {
  switch (view) {
    case ViewName::kOblique: return {-0.35, -1, 0.45};
    case ViewName::kAlongX: return {-1, 0, 0};
    case ViewName::kAlongY: return {0, -1, 0};
    case ViewName::kAlongZ: return {0, 0, -1};
    case ViewName::kDiagonal: return {-1, -1, 1};
  }
  return {};
}

}  // namespace

std::string name_of(SceneName scene) {
  switch (scene) {
    case SceneName::kBuckyball: return "buckyball";
    case SceneName::kHead: return "head";
    case SceneName::kCloud: return "cloud";
    case SceneName::kRock: return "rock";
    case SceneName::kGoldenRing: return "golden-ring";
    case SceneName::kMirrorBuckyball: return "mirror-buckyball";
    case SceneName::kMirrorHead: return "mirror-head";
    case SceneName::kFogBox: return "fog-box";
  }
  return {};
}

std::string name_of(ViewName view) {
  switch (view) {
    case ViewName::kOblique: return "oblique";
    case ViewName::kAlongX: return "along x";
    case ViewName::kAlongY: return "along y";
    case ViewName::kAlongZ: return "along z";
    case ViewName::kDiagonal: return "diagonal";
  }
  return {};
}

std::string about(SceneName scene) {
  switch (scene) {
    case SceneName::kBuckyball: return "C60 above a floor: opaque surfaces, much empty space";
    case SceneName::kHead: return "nested rough ellipsoids: translucent skin, skull and brain, empty corners";
    case SceneName::kCloud: return "noise that never gets opaque; no block is empty";
    case SceneName::kRock: return "noise that is opaque everywhere within a part of its edge; no block is empty";
    case SceneName::kGoldenRing: return "caustics: a polished ring on a floor under a point light";
    case SceneName::kMirrorBuckyball: return "C60 over a mirror before a wall, with its shadow";
    case SceneName::kMirrorHead: return "a head between two mirrors, a window and a lamp";
    case SceneName::kFogBox: return "coloured walls in fog: nearly every voxel takes light";
  }
  return {};
}

Colour background_of(SceneName scene) {
  return scene == SceneName::kBuckyball ? Colour{0.075, 0.085, 0.11} : Colour{0, 0, 0};
}

VolumeView SceneData::view() const {
  VolumeView result = volume.view();
  result.tags = tags;
  result.gradients = gradients;
  return result;
}

SceneData make_scene(SceneName name, const Dims& dims, int edge, int threads) {
  SceneData scene;
  switch (name) {
    case SceneName::kBuckyball: scene = make_ball(dims, threads); break;
    case SceneName::kHead: scene = make_head(dims, edge, threads); break;
    case SceneName::kCloud: scene = make_noise(dims, edge, 0.001, 0.007, {0.5, 0.6, 0.8}, {1, 1, 1}, threads); break;
    case SceneName::kRock:
      scene = make_noise(dims, edge, 0.03, 0.12, {0.3, 0.2, 0.15}, {0.8, 0.75, 0.6}, threads);
      break;
    case SceneName::kGoldenRing:
    case SceneName::kMirrorBuckyball:
    case SceneName::kMirrorHead:
    case SceneName::kFogBox: return make_lit_scene(name, edge, threads);
  }
  scene.box = name == SceneName::kHead ? visible_box(scene.volume, {scene.looks.front(), false}) : whole_box(dims);
  return scene;
}

TransferFunction faint(TransferFunction look) {
  for (OpacityPoint& point : look.opacities) point.opacity *= kFaint;
  return look;
}

View make_view(const SceneData& scene, ViewName name, int width, int height, bool orthographic) {
  View view;
  view.width = width;
  view.height = height;
  if (scene.lit_view && name == ViewName::kOblique) {
    view = *scene.lit_view;
    view.width = width;
    view.height = height;
    view.samples_per_axis = 1;
    return view;
  }
  const VoxelBox& box = scene.box;
  if (name == ViewName::kOblique) {
    fit_camera(scene.camera.value_or(CameraSettings{}), box, {1, 1, 1}, view);
    return view;
  }
  const Vec3 direction = (1 / length(direction_of(name))) * direction_of(name);
  view.look_at = 0.5 * (box.low + box.high);
  view.up = name == ViewName::kAlongZ ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  const double radius = 0.5 * length(box.high - box.low);
  if (orthographic) {
    view.orthographic_height = scene.volume.dims[1];
    view.eye = view.look_at + 2 * radius * direction;
    return view;
  }
  // As near as all corners allow.
  constexpr double kMargin = 1.02;  // chosen
  const Vec3 right = (1 / length(cross(view.up, direction))) * cross(view.up, direction), up = cross(direction, right);
  const double tan_up = std::tan(view.fov_degrees * std::numbers::pi / 360), tan_side = tan_up * width / height;
  double distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 offset = Vec3{(corner & 1) != 0 ? box.high.x : box.low.x, (corner & 2) != 0 ? box.high.y : box.low.y,
                             (corner & 4) != 0 ? box.high.z : box.low.z} -
                        view.look_at;
    const double aside = std::max(std::abs(dot(offset, right)) / tan_side, std::abs(dot(offset, up)) / tan_up);
    distance = std::max(distance, dot(offset, direction) + kMargin * aside);
  }
  view.eye = view.look_at + distance * direction;
  return view;
}

}  // namespace gicube::samples::results

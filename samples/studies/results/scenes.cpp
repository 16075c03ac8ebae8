#include "studies/results/scenes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "gicube/scene/voxeliser.h"
#include "scene/common/cells.h"

namespace gicube::samples::results {
namespace {

constexpr double kFaint = 0.003;     // chosen: 443 voxels of opacity 0.003 let a quarter through
constexpr double kDesignEdge = 256;  // voxels: opacities below are those of a volume of this edge

// Smooth noise without a period: values of 0..1 at hashed lattice points, joined by cubic weights.
double lattice_value(int x, int y, int z) {
  std::uint64_t hash = static_cast<std::uint32_t>(x) * 0x9E3779B97F4A7C15u;
  hash ^= static_cast<std::uint32_t>(y) * 0xC2B2AE3D27D4EB4Fu;
  hash ^= static_cast<std::uint32_t>(z) * 0x165667B19E3779F9u;
  hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9u;  // SplitMix64's finalizer
  hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EBu;
  return static_cast<double>((hash ^ (hash >> 31)) >> 40) / double(1 << 24);
}

double noise(Vec3 p) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
  const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
  const auto mix = [](double a, double b, double t) { return a + (b - a) * t; };
  const double u = smooth(p.x - fx), v = smooth(p.y - fy), w = smooth(p.z - fz);
  const auto row = [&](int dy, int dz) {
    return mix(lattice_value(x, y + dy, z + dz), lattice_value(x + 1, y + dy, z + dz), u);
  };
  return mix(mix(row(0, 0), row(1, 0), v), mix(row(0, 1), row(1, 1), v), w);
}

// Three octaves, 0..1.
double cloudy_noise(Vec3 p) {
  return (4 * noise(p) + 2 * noise(2.0 * p + Vec3{17, 5, 29}) + noise(4.0 * p + Vec3{3, 41, 11})) / 7;
}

// density(x, y, z) is 0..1.
using Density = std::function<double(Vec3)>;

Volume voxelise(const Dims& dims, const Density& density, int threads) {
  VoxelWorld world(dims, "built in", false);
  each_cell(dims, threads, [&](const Dims& first) {
    each_voxel(dims, first,
               [&](Vec3 p, std::size_t index) { world.set_density(index, std::clamp(density(p), 0.0, 1.0)); });
  });
  return std::move(world.volume);
}

// The opacity of a voxel of a volume of `edge`, so that the whole looks the same at every size.
double of_edge(double opacity, int edge) { return 1 - std::pow(1 - opacity, kDesignEdge / edge); }

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
  scene.materials = {
      {{{{0, {0.8, 0.6, 0.5}}, {1300, {0.85, 0.65, 0.55}}, {1800, {0.7, 0.45, 0.45}}, {3000, {0.95, 0.92, 0.85}}},
        {{200, 0}, {900, skin}, {1400, skin}, {1800, brain}, {2300, brain}, {3000, bone}}}}};
  scene.box = visible_box(scene.volume, scene.materials.front());
  return scene;
}

// Noise from end to end: no block is empty.
SceneData make_noise(const Dims& dims, int edge, double low, double high, Colour dark, Colour light, int threads) {
  const double lattice = edge / 8.0;
  SceneData scene;
  scene.volume = voxelise(
      dims, [&](Vec3 p) { return 0.1 + 0.8 * cloudy_noise((1 / lattice) * p); }, threads);
  scene.materials = {{{{{1000, dark}, {3000, light}}, {{1000, of_edge(low, edge)}, {3000, of_edge(high, edge)}}}}};
  scene.box = whole_box(dims);
  return scene;
}

SceneData make_lit_scene(const std::string& name, int edge, int threads) {
  const auto text = lit_scene_texts().find(name);
  if (text == lit_scene_texts().end()) throw InputError(name, "the name of a scene", "another");
  Scene scene = parse_scene(text->second, name + ".scene", {});
  if (!scene.world) throw InputError(name, "a scene with a world", "none");
  scene.world->size = edge;
  SceneData data{set_up(scene, threads), {}};
  if (scene.own_codebook) data.codebook = codebook_of(data.gradients);
  data.view.exposure = data.lighting.exposure;
  return data;
}

// Towards the eye.
Vec3 direction_of(const std::string& view) {
  if (view == "along x") return {-1, 0, 0};
  if (view == "along y") return {0, -1, 0};
  if (view == "along z") return {0, 0, -1};
  if (view == "diagonal") return {-1, -1, 1};
  throw InputError(view, "the name of a view", "another");
}

}  // namespace

Colour background_of(const std::string& scene) {
  return scene == "buckyball" ? Colour{0.075, 0.085, 0.11} : Colour{0, 0, 0};
}

SceneData make_scene(const std::string& name, const Dims& dims, int edge, int threads) {
  if (name == "buckyball") {
    Scene scene;
    scene.volume.builtin = name;
    scene.volume.size = dims[0];
    return {set_up(scene, threads), {}};
  }
  if (name == "head") return make_head(dims, edge, threads);
  if (name == "cloud") return make_noise(dims, edge, 0.001, 0.007, {0.5, 0.6, 0.8}, {1, 1, 1}, threads);
  if (name == "rock") return make_noise(dims, edge, 0.03, 0.12, {0.3, 0.2, 0.15}, {0.8, 0.75, 0.6}, threads);
  return make_lit_scene(name, edge, threads);
}

TransferFunction faint(TransferFunction transfer_function) {
  for (OpacityPoint& point : transfer_function.opacities) point.opacity *= kFaint;
  return transfer_function;
}

View make_view(const SceneData& scene, const std::string& name, int width, int height, bool orthographic) {
  const bool own_camera = name == "oblique" && !scene.lights.empty();
  View view = own_camera ? scene.view : View{};
  view.width = width;
  view.height = height;
  view.samples_per_axis = 1;
  if (own_camera) return view;
  const SceneBox& box = scene.box;
  if (name == "oblique") {
    fit_camera(scene.built_in.camera, box, {1, 1, 1}, view);
    return view;
  }
  const Vec3 direction = normalise(direction_of(name));
  view.look_at = 0.5 * (box.low + box.high);
  view.up = name == "along z" ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  const double radius = 0.5 * length(box.high - box.low);
  if (orthographic) {
    view.orthographic_height = scene.volume.dims[1];
    view.eye = view.look_at + 2 * radius * direction;
    return view;
  }
  // As near as all corners allow.
  constexpr double kMargin = 1.02;  // chosen
  const Vec3 right = normalise(cross(view.up, direction)), up = cross(direction, right);
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

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "scene/buckyball.h"
#include "scene/common/checks.h"
#include "scene/formats/plane_file.h"
#include "scene/hashes.h"
#include "scene/label_map.h"

namespace gicube::scene {
namespace {

constexpr int kMaxAnalyticSize =
    256;  // voxels along an edge: normals, 12 bytes per voxel, need too much memory beyond it
constexpr double kLitAmbient = 0.03;    // chosen: surfaces without lighting rays are almost black
constexpr double kLightDistance = 1.5;  // chosen: of a volume file's own point light, in diagonals from the centre

void take_buckyball(const Scene& scene, int threads, SceneSetup& setup) {
  const int size = scene.volume.size;
  static_cast<VoxelWorld&>(setup) = make_buckyball(size, size <= kMaxAnalyticSize, threads);
  setup.built_in = buckyball_appearance(size);
}

void take_world(const Scene& scene, int threads, SceneSetup& setup) {
  BuiltWorld built = build(*scene.world, scene.materials, threads);
  setup.grid = built.grid;
  static_cast<VoxelWorld&>(setup) = std::move(built.voxels);
  setup.built_in.materials = std::move(built.looks);
}

// Converts a function of Hounsfield or robust values to the volume's values, if there is a survey.
TransferFunctionFile settled(const SceneSetup& setup, const TransferFunctionFile& file) {
  const bool asks = file.scale == TransferScale::kHounsfield || file.scale == TransferScale::kRobust;
  return asks && setup.survey ? in_values_of(*setup.survey, setup.survey->range, file) : file;
}

// Whether an absolute function has points beyond the range that a survey proposes.
bool leaves(const TransferFunctionFile& file, const ValueRange& range) {
  if (file.scale != TransferScale::kAbsolute) return false;
  return std::ranges::any_of(file.function.opacities, [&range](const OpacityPoint& point) {
    return point.value < range.low || point.value > range.high;
  });
}

bool is_auto(const Scene& scene) {
  return !scene.transfer_function &&
         std::ranges::none_of(scene.materials, [](const SceneMaterial& material) { return material.look.has_value(); });
}

// Whether the range omits single extreme values.
bool narrows(const Scene& scene, const Survey& survey) {
  return !scene.range && !(survey.range == survey.whole) &&
         !(scene.transfer_function && leaves(*scene.transfer_function, survey.range));
}

// The range of a volume file's values, and its look.
void take_values(const Scene& scene, SceneSetup& setup) {
  setup.survey = survey_of(setup.volume);
  Survey& survey = *setup.survey;
  if (scene.range) {
    if (!(scene.range->low < scene.range->high))
      throw InputError("range", "a lower number before a higher one",
                       fmt::format("{},{}", scene.range->low, scene.range->high));
    setup.volume.range = survey.range = survey.robust = *scene.range;
  } else if (narrows(scene, survey)) {
    setup.volume.range = survey.range;
  } else if (!setup.volume.range && survey.whole.low < survey.whole.high) {
    setup.volume.range = survey.whole;  // otherwise visible_box() and the driver would search it again
  }
  if (!setup.volume.colours.empty() || setup.volume.colour_planes) {
    setup.built_in.materials = {find_preset("colours")};
    return;
  }
  const AutomaticLook look = automatic_look(survey, scene.range);
  setup.built_in.materials = {look.function};
  if (!is_auto(scene)) return;
  setup.look_why = look.why;
  if (survey.kind == DataKind::kLabels || survey.kind == DataKind::kMask) colour_labels(setup);
}

// Replaces the volume's looks by those of the materials.
void set_material_looks(const Scene& scene, SceneSetup& setup) {
  for (const SceneMaterial& material : scene.materials) {
    const auto tag = static_cast<std::size_t>(material.tag);
    if (!material.look || scene.world) continue;
    const auto* function = look_as<TransferFunctionFile>(material);
    if (function == nullptr) {
      throw InputError("material[" + material.name + "]", "a transfer_function, as for all volume files",
                       "a solid or fog");
    }
    if (setup.materials.size() <= tag) setup.materials.resize(tag + 1, setup.materials.front());
    setup.materials[tag] = *function;
  }
}

CameraSettings in_voxels(CameraSettings camera, const WorldGrid& grid) {
  if (camera.eye) camera.eye = grid.voxel_of(*camera.eye);
  if (camera.look_at) camera.look_at = grid.voxel_of(*camera.look_at);
  if (camera.orthographic_height) *camera.orthographic_height /= grid.voxel;
  return camera;
}

void set_camera(const Scene& scene, SceneSetup& setup) {
  // The built-in camera and the user's are not mixed, which would show nothing.
  const CameraSettings& asked = scene.camera;
  const bool own =
      asked.eye || asked.look_at || asked.up || asked.fov_degrees || asked.orthographic_height || !asked.from.empty();
  setup.view = scene.view;
  for (CutPlane& plane : setup.view.cut_planes) {
    plane.offset = (plane.offset - dot(plane.normal, setup.grid.low)) / setup.grid.voxel;
  }
  fit_camera(own ? in_voxels(asked, setup.grid) : setup.built_in.camera, setup.box, setup.volume.spacing, setup.view,
             setup.volume.placement.axes);
}

// A point light outside the volume, in the direction of the light of pictures without illumination.
PointLight default_light(const SceneSetup& setup) {
  const Vec3& spacing = setup.volume.spacing;
  const double least = std::min({spacing.x, spacing.y, spacing.z});
  const Vec3 scale = (1 / least) * spacing;
  const Vec3 middle = 0.5 * Vec3{setup.volume.dims[0] - 1.0, setup.volume.dims[1] - 1.0, setup.volume.dims[2] - 1.0};
  const double diagonal = 2 * length({middle.x * scale.x, middle.y * scale.y, middle.z * scale.z});
  const Vec3 away = kLightDistance * diagonal * normalise(setup.shading.light);
  return {middle + Vec3{away.x / scale.x, away.y / scale.y, away.z / scale.z}, 1};
}

void set_lights(const Scene& scene, SceneSetup& setup) {
  setup.lighting = scene.lighting;
  setup.lighting.exposure /= setup.grid.voxel * setup.grid.voxel;  // a voxel's face gets less power by this factor
  setup.lights.clear();
  setup.light_colours.clear();
  std::optional<Vec3> towards = scene.light ? scene.light : setup.built_in.light;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const SceneLight& light = scene.lights[i];
    try {
      check(light);
    } catch (const InputError& error) {
      throw InputError(within("light[" + (light.name.empty() ? std::to_string(i) : light.name) + "]", error, "."));
    }
    setup.lights.push_back(in_voxels(light.light, setup.grid));
    setup.light_colours.push_back(light.colour);
    const auto* directional = std::get_if<DirectionalLight>(&light.light);
    if (directional != nullptr && !towards) towards = directional->towards;
  }
  Phong phong = setup.built_in.phong;
  if (scene.lighting.on) phong.ambient = kLitAmbient, phong.specular = 0;
  setup.shading = {scene.phong.value_or(phong), towards ? *towards : shoulder_light(setup.view, setup.volume.spacing)};
  if (scene.lighting.on && setup.lights.empty()) {
    setup.lights.push_back(default_light(setup));
    setup.light_colours.push_back({1, 1, 1});
  }
}

void set_optics(const Scene& scene, SceneSetup& setup) {
  setup.looks.clear();
  setup.optics.clear();
  setup.scattering_colours.clear();
  setup.emissions.clear();
  for (const SceneMaterial& material : scene.materials) {
    check(material);
    const auto tag = static_cast<std::size_t>(material.tag);
    if (setup.optics.size() <= tag) {
      setup.looks.resize(tag + 1, TransferFunctionFile{});
      setup.optics.resize(tag + 1);
      setup.scattering_colours.resize(tag + 1, {1, 1, 1});
      setup.emissions.resize(tag + 1, {0, 0, 0});
    }
    const MaterialLook unset = scene.world ? MaterialLook{SolidLook{}} : TransferFunctionFile{};
    setup.looks[tag] = material.look.value_or(unset);
    setup.optics[tag] = material.optics;
    setup.scattering_colours[tag] = material.scattering_colour;
    for (std::size_t c = 0; c < 3; ++c) setup.emissions[tag][c] = material.emission * material.emission_colour[c];
    setup.view.scatter = setup.view.scatter || material.optics.seen_through_scattering;
  }
}

// Lights that mirrors show: distant and point lights have no size.
void set_lamps(const Scene& scene, SceneSetup& setup) {
  setup.view.lamps.clear();
  if (!scene.lighting.on || !setup.view.scatter) return;
  for (std::size_t i = 0; i < setup.lights.size(); ++i) {
    const Light& light = setup.lights[i];
    if (!std::holds_alternative<RectangleLight>(light) && !std::holds_alternative<SphereLight>(light)) continue;
    setup.view.lamps.push_back({light, scene.lighting.colour_passes ? setup.light_colours[i] : Colour{1, 1, 1}});
  }
}

Volume volume_of(const VolumeSource& source) {
  Volume volume = open_volume(source);
  const bool is_small = voxels_of(volume.dims) * bytes_per_sample(volume.type) <= kMaxWholeBytes;
  if (!source.in_planes || is_small) take_planes(volume);
  return volume;
}

}  // namespace

VolumeView SceneSetup::volume_view() const {
  VolumeView result = volume.view();
  result.tags = tags;
  result.gradients = gradients;
  return result;
}

void SceneSetup::free_voxels() {
  std::vector<std::byte>().swap(volume.samples);
  std::vector<std::uint8_t>().swap(tags);
  std::vector<float>().swap(gradients);
}

SceneSetup set_up(const Scene& scene, int threads) {
  SceneSetup setup;
  if (scene.world) {
    take_world(scene, threads, setup);
  } else if (scene.volume.builtin.empty()) {
    setup.volume = volume_of(scene.volume);
    take_values(scene, setup);
  } else if (scene.volume.builtin == "buckyball") {
    take_buckyball(scene, threads, setup);
  } else {
    throw InputError("built-in volume", "buckyball", in_quotes(scene.volume.builtin));
  }
  if (scene.volume.spacing) setup.volume.spacing = *scene.volume.spacing;
  setup.voxel_hash = hash_of_voxels(setup);
  setup.box = whole_box(setup.volume.dims);
  if (!scene.world && scene.volume.builtin.empty() && !scene.camera.eye) {
    const Materials& own = setup.built_in.materials;
    setup.box =
        visible_box(setup.volume, settled(setup, scene.transfer_function ? *scene.transfer_function : own.front()));
  }
  set_look(scene, setup);
  return setup;
}

void set_look(const Scene& scene, SceneSetup& setup) {
  setup.materials = setup.built_in.materials;
  set_material_looks(scene, setup);
  if (scene.transfer_function) setup.materials.assign(setup.materials.size(), *scene.transfer_function);
  for (TransferFunctionFile& material : setup.materials) material = settled(setup, material);
  setup.background = scene.background ? scene.background : setup.built_in.background;
  set_camera(scene, setup);
  set_lights(scene, setup);
  set_optics(scene, setup);
  set_lamps(scene, setup);
  setup.view.irradiance = scene.lighting.on;
}

bool keeps_voxels(const Scene& scene, const SceneSetup& setup) {
  if (!setup.survey) return true;
  const Survey& survey = *setup.survey;
  const bool labels = survey.kind == DataKind::kLabels || survey.kind == DataKind::kMask;
  const bool is_narrow = !(survey.range == survey.whole) && setup.volume.range == survey.range && !scene.range;
  return (!labels || is_auto(scene) == !setup.look_why.empty()) && narrows(scene, survey) == is_narrow;
}

bool same_voxels(const Scene& a, const Scene& b) {
  return a.volume == b.volume && a.world == b.world && a.range == b.range;
}

bool same_illumination(const Scene& a, const Scene& b) {
  const auto same_light = [](const SceneLight& x, const SceneLight& y) {
    return x.light == y.light && x.colour == y.colour;
  };
  return same_voxels(a, b) && a.lighting.on == b.lighting.on && a.lighting.colour_passes == b.lighting.colour_passes &&
         a.lighting.settings == b.lighting.settings && std::ranges::equal(a.lights, b.lights, same_light);
}

}  // namespace gicube::scene

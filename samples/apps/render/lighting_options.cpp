#include "render/options.h"

#include <fmt/format.h>

#include "scene/program/option_group.h"

namespace gicube::samples {
namespace {

constexpr int kMaxFrames = 100'000;  // chosen: five digits, which file names then have
constexpr double kFps = 25;          // chosen

}  // namespace

void add_lighting_options(CLI::App& app, LightingOptions& options) {
  OptionGroup group(app, "Global illumination");
  group
      .value("--illumination", options.illumination,
             "lighting rays: none, low (rays deposit light along their path) or high (photons) (the scene's; none)")
      ->check(CLI::IsMember({"none", "low", "high"}));
  group.value("--rules", options.rules, "of energy: as-printed or conserving (conserving)")
      ->check(CLI::IsMember({"as-printed", "conserving"}));
  group.value("--light-rays", options.rays, "k, lighting rays per voxel of the volume's faces (1)")
      ->check(CLI::Range(1, 4096));
  group.value("--lifetime", options.lifetime, "scatterings until a ray is dropped (lighting rays 32, viewing rays 8)")
      ->check(CLI::Range(0, 1023));
  group.value("--exposure", options.exposure, "brightness of a surface with unit power per unit area; 0: chosen (0)")
      ->check(CLI::Range(0.0, 1e12));
  group
      .value("--irradiance", options.field,
             "known light of one or three channels (NRRD, as written by gicube-form-factors) that replaces lighting "
             "rays")
      ->type_name("FILE");
  group.flag("--colour-passes", options.colour_passes, "separate passes for red, green and blue light");
}

void add_animation_options(CLI::App& app, AnimationOptions& options) {
  OptionGroup group(app, "Animation");
  group.value("--time", options.start, "time of the scene's engines in the first picture, in seconds (0)")
      ->check(CLI::Range(-1e6, 1e6));
  group.value("--frames", options.frames, "number of pictures, named out_0000.png and so on (1, not numbered)")
      ->check(CLI::Range(1, kMaxFrames));
  group.value("--fps", options.fps, "pictures per second (25)")->check(CLI::Range(1e-3, 1e6));
  group.value("--duration", options.duration, "seconds from the first picture to the one after the last")
      ->check(CLI::Range(1e-6, 1e6));
}

void check_animation(const AnimationOptions& options) {
  if (options.fps && options.duration) throw UsageError("--fps: expected it or --duration, got both");
  if ((options.fps || options.duration) && options.frames == 1) {
    throw UsageError("--frames: expected more than one with --fps and --duration, got 1");
  }
}

void set_lighting(const LightingOptions& options, Scene& scene) {
  Lighting& lighting = scene.lighting;
  if (!options.field.empty()) {
    if (!options.illumination.empty()) throw UsageError("--irradiance: expected it or --illumination, got both");
    lighting.on = false;
    if (!scene.phong) scene.phong = Phong{.ambient = 0, .diffuse = 1, .specular = 0};  // all light is in the field
  }
  if (!options.illumination.empty()) set_albedo(options.illumination, "--illumination", lighting);
  if (!options.rules.empty()) lighting.settings.rules = rules_named(options.rules, "--rules");
  lighting.settings.rays_per_face_voxel = options.rays.value_or(lighting.settings.rays_per_face_voxel);
  lighting.settings.lifetime = options.lifetime.value_or(lighting.settings.lifetime);
  scene.view.lifetime = options.lifetime.value_or(scene.view.lifetime);
  lighting.exposure = options.exposure.value_or(lighting.exposure);
  lighting.colour_passes = lighting.on && (lighting.colour_passes || options.colour_passes);
  scene.view.high_albedo = scene.view.high_albedo && lighting.on;
}

std::vector<double> frame_times(const AnimationOptions& options) {
  const double step = options.duration ? *options.duration / options.frames : 1 / options.fps.value_or(kFps);
  std::vector<double> times;
  for (int i = 0; i < options.frames; ++i) times.push_back(options.start.value_or(0) + i * step);
  return times;
}

std::filesystem::path frame_file(const std::filesystem::path& output, const AnimationOptions& options, int frame) {
  if (options.frames == 1) return output;
  return output.parent_path() / fmt::format("{}_{:04}{}", output.stem().string(), frame, output.extension().string());
}

}  // namespace gicube::samples

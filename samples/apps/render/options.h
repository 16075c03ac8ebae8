// The command line of gicube-render.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <initializer_list>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/scene/image_file.h"
#include "gicube/scene/scene.h"
#include "scene/names.h"
#include "scene/program/board_options.h"
#include "scene/program/plan_options.h"
#include "scene/program/scene_input.h"

namespace gicube::samples {

// Options that are not set are left to the scene.
struct LightingOptions {
  std::string illumination;  // none, low, high; empty: the scene's
  std::string rules;         // conserving, as-printed; empty: the scene's
  std::optional<int> rays;   // k, per voxel of the faces
  std::optional<int> lifetime;
  std::optional<double> exposure;
  bool colour_passes = false;
  std::filesystem::path field;  // known light that replaces lighting rays; empty: none
};

struct AnimationOptions {
  std::optional<double> start;  // seconds; 0
  int frames = 1;
  std::optional<double> fps;       // 25 without both
  std::optional<double> duration;  // seconds from the first frame to the one after the last
};

// A checkpoint between two pictures of a run.
struct CheckpointOptions {
  enum class Unit { kFrame, kMilliseconds, kRay };
  std::filesystem::path file;  // the output; empty: none
  std::optional<Unit> unit;    // of `at`
  double at = 0;
  int first_frame = 0;  // with BoardOptions::restore
};

void add_lighting_options(CLI::App& app, LightingOptions& options);
void add_animation_options(CLI::App& app, AnimationOptions& options);
struct RenderOptions;
void add_checkpoint_options(CLI::App& app, RenderOptions& options);
// Throws UsageError: a checkpoint that cannot be restored, or is never written.
void check_checkpoint_options(const RenderOptions& options);

// Throws UsageError that names `option` and the first of `others` that is given with it: --max-error or --time-budget,
// --crop, --level-of-detail, --colour-passes, --irradiance, --explain-pixel, --checkpoint or --restore.
void expect_without(const RenderOptions& options, const std::string& option,
                    std::initializer_list<std::string_view> others);

// Throws UsageError: fps or a duration without frames, or both.
void check_animation(const AnimationOptions& options);

void set_lighting(const LightingOptions& options, Scene& scene);

// The time of each frame, in seconds.
std::vector<double> frame_times(const AnimationOptions& options);

// "out.png" as "out_0007.png"; `output` itself for a single picture.
std::filesystem::path frame_file(const std::filesystem::path& output, const AnimationOptions& options, int frame);

// Options that are not set are left to the scene, or to their defaults.
struct RenderOptions : SceneInput {
  std::optional<Dims> dims;  // these four describe a file without a header
  std::optional<SampleType> type;
  bool big_endian = false;
  std::uint64_t skip_bytes = 0;
  std::optional<Vec3> spacing;
  std::optional<ValueRange> range;
  bool annotate = false;
  std::string camera_name;  // of the scene's; empty: its first
  CameraSettings camera;
  std::optional<std::array<int, 2>> size;
  std::optional<int> samples;
  std::optional<PixelFilter> filter;
  std::optional<double> step, threshold;
  bool crop = false;
  int level_of_detail = 0;  // each voxel stands for 2^level along each axis
  double brick_detail = 0;  // the largest width of a coarse block's cell in pixels; 0: no coarse blocks
  bool no_shade = false, jitter = false, no_leap = false;
  std::vector<CutPlane> cut_planes;
  std::optional<Vec3> light;
  std::optional<double> ambient, diffuse, specular, shininess;
  std::optional<Colour> background;
  bool no_background = false;
  std::optional<Composite> composite;
  LightingOptions lighting;
  AnimationOptions animation;
  std::filesystem::path output = "gicube-render.png";
  std::optional<std::array<int, 2>> explain_pixel;  // column and row, from 0, from the upper left
  std::filesystem::path explain_svg;                // empty: none
  PlanOptions plan;
  CheckpointOptions checkpoint;
  BoardOptions board;
};

// Nothing if help or the version was requested and written to `out`. Throws UsageError with one line.
std::optional<RenderOptions> parse_options(int argc, const char* const* argv, std::ostream& out);

// The input's scene, with the options of its volume. Throws UsageError (options that contradict the input), InputError
// (a scene or transfer function file).
Scene input_scene(const RenderOptions& options);
// That scene at a time, overridden by the other options. Throws UsageError and InputError.
Scene scene_at(const Scene& input, const RenderOptions& options, double time);
// Both, at the time of the first picture.
Scene scene_of(const RenderOptions& options);

// Replaces Phong's coefficients by those of the options.
void set_phong(const RenderOptions& options, Phong& phong);

}  // namespace gicube::samples

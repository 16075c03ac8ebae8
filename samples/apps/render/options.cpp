#include "render/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "scene/common/checks.h"
#include "scene/program/option_group.h"
#include "scene/program/program.h"
#include "scene/program/scene_input.h"

namespace gicube::samples {
namespace {

const char* const kFooter =
    "Positions and lengths are voxels, or world units in a scene with a world. Voxel (0, 0, 0) has its centre at the\n"
    "origin; x, y, z run to the patient's left, back and head if the file gives these directions, otherwise along the\n"
    "file's axes. Directions of light and angles are physical. Without --eye, the camera shows everything visible, "
    "from\n"
    "-y and slightly above (+z is up).\n"
    "Exit codes: 0 done, 1 failed, 2 wrong usage.";

void add_volume_options(CLI::App& app, RenderOptions& options) {
  OptionGroup group(app, "Volume");
  group.parsed("--dims", "X,Y,Z", "size in voxels of a file without a header",
               [&](const std::string& name, const std::string& text) {
                 const std::vector<int> sizes = parse_sizes(name, text, 3, ',');
                 options.dims = Dims{sizes[0], sizes[1], sizes[2]};
               });
  group.parsed("--type", "TYPE", "its samples: uint8, uint12, uint16, int16 or float32 (uint8)",
               [&](const std::string&, const std::string& text) { options.type = sample_type_named(text, "type"); });
  group.flag("--big-endian", options.big_endian, "its samples are big-endian");
  group.value("--skip", options.skip_bytes, "bytes before its first sample");
  group.parsed("--spacing", "X,Y,Z", "physical voxel edges that replace the file's",
               [&](const std::string& name, const std::string& text) {
                 options.spacing = parse_vector(name, text);
                 if (!(options.spacing->x > 0 && options.spacing->y > 0 && options.spacing->z > 0)) {
                   throw CLI::ValidationError(name, "expected numbers above 0, got " + in_quotes(text));
                 }
               });
}

void add_camera_options(CLI::App& app, RenderOptions& options) {
  OptionGroup group(app, "Camera and image");
  group.value("--camera", options.camera_name, "one of the scene's cameras by its name (the first)")->type_name("NAME");
  group.vector("--eye", options.camera.eye, "the viewer's position");
  group
      .value("--view", options.camera.from,
             "show everything from the front, back, left, right, top, bottom, or iso; with a patient also anterior, "
             "posterior, superior or inferior")
      ->type_name("NAME");
  group.vector("--look-at", options.camera.look_at, "point in the image's centre (the centre of everything visible)");
  group.direction("--up", options.camera.up, "this direction is up in the image (0,0,1)");
  CLI::Option* fov = group.value("--fov", options.camera.fov_degrees, "vertical field of view in degrees (30)");
  fov->check(CLI::Range(0.01, 179.0));
  group.value("--orthographic", options.camera.orthographic_height, "parallel rays; the image's height in voxels")
      ->check(CLI::PositiveNumber)
      ->excludes(fov);
  group.parsed("--size", "WxH", "pixels of the image (512x512)", [&](const std::string& name, const std::string& text) {
    const std::vector<int> sizes = parse_sizes(name, text, 2, 'x');
    if (std::max(sizes[0], sizes[1]) > 4095)
      throw CLI::ValidationError(name, "expected at most 4095 pixels a side, got " + in_quotes(text));
    options.size = {sizes[0], sizes[1]};
  });
  group.value("--samples", options.samples, "samples per pixel along each axis: 1, 2 or 4 (1)")
      ->check(CLI::IsMember({1, 2, 4}));
  group.parsed("--filter", "FILTER", "weights of a pixel's samples: box or tent (box)",
               [&](const std::string& name, const std::string& text) {
                 if (text != "box" && text != "tent")
                   throw CLI::ValidationError(name, "expected box or tent, got " + in_quotes(text));
                 options.filter = text == "box" ? PixelFilter::kBox : PixelFilter::kTent;
               });
  group.parsed("--background", "R,G,B",
               "colour 0..1 behind the picture, or none (none; built-in scenes have their own)",
               [&](const std::string& name, const std::string& text) {
                 options.no_background = text == "none";
                 options.background.reset();
                 if (options.no_background) return;
                 const std::vector<double> rgb = parse_numbers(name, text, 3);
                 const auto [least, most] = std::minmax_element(rgb.begin(), rgb.end());
                 if (*least < 0 || *most > 1)
                   throw CLI::ValidationError(name, "expected numbers from 0 to 1, got " + in_quotes(text));
                 options.background = {rgb[0], rgb[1], rgb[2]};
               });
  group.parsed(
      "--composite", "HOW",
      "how the background is blended: in display-referred values (display, the default of PNG) or in linear light "
      "(linear); an EXR then has no alpha",
      [&](const std::string& name, const std::string& text) {
        if (text != "display" && text != "linear")
          throw CLI::ValidationError(name, "expected display or linear, got " + in_quotes(text));
        options.composite = text == "linear" ? Composite::kLinear : Composite::kDisplay;
      });
  group.flag("--annotate", options.annotate,
             "draw the axes in a corner: R L A P S I of a patient if the file has an orientation, otherwise x y z");
  group.value("-o,--output", options.output, "the picture: PNG (8 bit) or EXR (linear float with alpha)")
      ->type_name("FILE")
      ->capture_default_str();
}

void add_sampling_options(CLI::App& app, RenderOptions& options) {
  OptionGroup group(app, "Sampling and light");
  group.value("--step", options.step, "distance of samples along a ray, in voxels (0.5)")
      ->check(CLI::Range(1.0 / 64, 16.0));
  group.value("--threshold", options.threshold, "opacity at which a ray ends (0.98)")->check(CLI::Range(0.0, 1.0));
  group.flag("--jitter", options.jitter, "vary the distance of samples, to avoid banding");
  group.flag("--no-leap", options.no_leap, "sample empty blocks too");
  group.flag("--crop", options.crop, "load only the part of the volume with visible voxels");
  group
      .value("--level-of-detail", options.level_of_detail,
             "load a coarser volume: one voxel for 2^N along each axis; --step is in its voxels")
      ->check(CLI::Range(0, 6))
      ->type_name("N")
      ->capture_default_str();
  group
      .value("--brick-detail", options.brick_detail,
             "for a volume larger than the card: send blocks as means of 2, 4 or 8 voxels along each edge where these "
             "are at most X pixels wide")
      ->check(CLI::Range(0.0, 64.0))
      ->type_name("X");
  group.flag("--no-shade", options.no_shade, "colours without shading");
  group.direction("--light", options.light, "direction towards the light (above the viewer's left shoulder)");
  group.value("--ambient", options.ambient, "Phong's coefficients")->check(CLI::Range(0.0, 1.99));
  group.value("--diffuse", options.diffuse, "")->check(CLI::Range(0.0, 1.99));
  group.value("--specular", options.specular, "")->check(CLI::Range(0.0, 1.99));
  group.value("--shininess", options.shininess, "")->check(CLI::Range(1.0, 1000.0));
  group.parsed(
      "--range", "LOW,HIGH",
      "a volume file's values for the lowest and the highest density, at the points 0 and 1 of most presets; does not "
      "change Hounsfield units (found from the values)",
      [&](const std::string& name, const std::string& text) {
        const std::vector<double> ends = parse_numbers(name, text, 2);
        if (!(ends[0] < ends[1]))
          throw CLI::ValidationError(name, "expected a lower number before a higher one, got " + in_quotes(text));
        options.range = ValueRange{ends[0], ends[1]};
      });
  group
      .parsed("--cut", "NX,NY,NZ,OFFSET", "show only the points p with N.p >= OFFSET; repeatable, at most 6",
              [&](const std::string& name, const std::string& text) {
                const std::vector<double> plane = parse_numbers(name, text, 4);
                const Vec3 normal{plane[0], plane[1], plane[2]};
                if (length(normal) == 0)
                  throw CLI::ValidationError(name, "expected a direction, got " + in_quotes(text));
                options.cut_planes.push_back({normal, plane[3]});
              })
      ->take_all();
}

void check_output(const RenderOptions& options) {
  if (!options.camera.from.empty() && options.camera.eye) throw UsageError("--view: expected without --eye, got both");
  check_picture_name(options.output);
  if (options.composite && options.no_background) throw UsageError("--composite: expected with a background, got none");
  if (options.output.extension() == ".exr" && options.background && !options.composite)
    throw UsageError("--background: expected with --composite for an EXR file, which keeps its alpha otherwise");
}

// Refuses options that a plan chooses itself, and a field of light, which it does not support.
void check_plan_options(const CLI::App& app, const RenderOptions& options) {
  check_plan(options.plan);
  if (!options.plan.wanted()) return;
  for (const char* chosen : {"--step", "--threshold", "--light-rays", "--crop", "--level-of-detail"}) {
    refuse_with_plan(app, chosen);
  }
  if (!options.lighting.field.empty())
    throw UsageError("--irradiance: expected none with --max-error and --time-budget");
}

void add_explain_options(CLI::App& app, RenderOptions& options) {
  OptionGroup group(app, "One pixel");
  group.parsed("--explain-pixel", "X,Y",
               "print every sample of the rays of the pixel in column X and row Y, from 0 and the upper left; on a "
               "private board",
               [&](const std::string& name, const std::string& text) {
                 const std::vector<double> place = parse_numbers(name, text, 2);
                 for (const double at : place) {
                   if (at != std::floor(at) || at < 0 || at > 4094)
                     throw CLI::ValidationError(name,
                                                "expected two whole numbers from 0 to 4094, got " + in_quotes(text));
                 }
                 options.explain_pixel = {static_cast<int>(place[0]), static_cast<int>(place[1])};
               });
  group.file("--explain-svg", options.explain_svg, "draw these samples as a strip");
}

// Only one picture, made by one command of one board, can be explained.
void check_explain_options(const RenderOptions& options) {
  if (!options.explain_pixel) {
    if (!options.explain_svg.empty())
      throw UsageError("--explain-svg: expected --explain-pixel X,Y beside it, got none");
    return;
  }
  const bool several = !options.board.others.empty() || options.board.board.find("boards=") != std::string::npos;
  const char* const against = !options.board.board.starts_with("emu:") ? "a running board (--board)"
                              : several                                ? "several boards"
                              : options.animation.frames > 1           ? "more than one of --frames"
                                                                       : nullptr;
  if (against != nullptr) throw UsageError(std::string("--explain-pixel: expected without ") + against);
  expect_without(options, "--explain-pixel", {"--max-error or --time-budget", "--colour-passes", "--irradiance"});
}

void add_host_options(CLI::App& app) {
  OptionGroup group(app, "Several hosts");
  group.parsed("--mpi", "HOW",
               "rays: under mpirun, each rank has a board and a part of the volume, and ranks exchange rays; the "
               "picture has the "
               "same bits as on one board",
               [](const std::string& name, const std::string& text) {
                 if (text != "rays")
                   throw CLI::ValidationError(
                       name, "expected rays, a picture with the bits of one board, got " + in_quotes(text));
               });
}

bool has_layout(const RenderOptions& options) {
  return options.dims || options.type || options.big_endian || options.skip_bytes != 0;
}

void set_volume(const RenderOptions& options, Scene& scene) {
  VolumeSource& volume = scene.volume;
  if (scene.world && (has_layout(options) || options.spacing)) {
    throw UsageError("--dims, --type, --big-endian, --skip, --spacing: only for a volume; " + in_quotes(options.input) +
                     " has a world");
  }
  if (has_layout(options)) {
    if (!volume.builtin.empty())
      throw UsageError("--dims, --type, --big-endian, --skip: only for a file without a header");
    if (!options.dims && !volume.raw)
      throw UsageError("--dims: expected with --type, --big-endian and --skip, got none");
    RawLayout layout = volume.raw.value_or(RawLayout{});
    layout.dims = options.dims.value_or(layout.dims);
    layout.type = options.type.value_or(layout.type);
    layout.big_endian = layout.big_endian || options.big_endian;
    if (options.skip_bytes != 0) layout.skip_bytes = options.skip_bytes;
    volume.raw = layout;
  }
  if (options.spacing) volume.spacing = options.spacing;
}

void set_camera(const CameraSettings& options, CameraSettings& camera) {
  if (options.eye) camera.eye = options.eye;
  if (!options.from.empty()) camera.from = options.from, camera.eye.reset(), camera.up.reset();
  if (options.look_at) camera.look_at = options.look_at;
  if (options.up) camera.up = options.up;
  if (options.fov_degrees) camera.fov_degrees = options.fov_degrees, camera.orthographic_height.reset();
  if (options.orthographic_height) camera.orthographic_height = options.orthographic_height, camera.fov_degrees.reset();
}

void set_view(const RenderOptions& options, View& view) {
  if (options.size) view.width = (*options.size)[0], view.height = (*options.size)[1];
  view.samples_per_axis = options.samples.value_or(view.samples_per_axis);
  view.filter = options.filter.value_or(view.filter);
  view.step = options.step.value_or(view.step);
  view.opacity_threshold = options.threshold.value_or(view.opacity_threshold);
  view.shade = view.shade && !options.no_shade;
  view.jitter = view.jitter || options.jitter;
  view.leap = view.leap && !options.no_leap;
  view.cut_planes.insert(view.cut_planes.end(), options.cut_planes.begin(), options.cut_planes.end());
  if (view.cut_planes.size() > 6)
    throw UsageError("--cut: expected at most 6 planes, got " + std::to_string(view.cut_planes.size()));
}

}  // namespace

Scene input_scene(const RenderOptions& options) {
  Scene scene = input_scene(static_cast<const SceneInput&>(options));
  set_volume(options, scene);
  if (options.range && (scene.world || !scene.volume.builtin.empty()))
    throw UsageError("--range: only for a volume file; " + in_quotes(options.input) + " has values of its own");
  if (options.range) scene.range = options.range;
  return scene;
}

void expect_without(const RenderOptions& options, const std::string& option,
                    std::initializer_list<std::string_view> others) {
  const bool has_checkpoint = options.checkpoint.unit || !options.board.restore.empty();
  const std::pair<std::string_view, bool> given[] = {{"--max-error or --time-budget", options.plan.wanted()},
                                                     {"--crop", options.crop},
                                                     {"--level-of-detail", options.level_of_detail > 0},
                                                     {"--colour-passes", options.lighting.colour_passes},
                                                     {"--irradiance", !options.lighting.field.empty()},
                                                     {"--explain-pixel", options.explain_pixel.has_value()},
                                                     {"--checkpoint or --restore", has_checkpoint}};
  for (const auto& [name, is_given] : given) {
    if (is_given && std::ranges::count(others, name) > 0)
      throw UsageError(fmt::format("{}: expected without {}", option, name));
  }
}

std::optional<RenderOptions> parse_options(int argc, const char* const* argv, std::ostream& out) {
  RenderOptions options;
  CLI::App app("Renders a volume on a GI-Cube board.", "gicube-render");
  app.footer("Presets of --transfer-function, and their use:\n" + preset_lines() + kFooter);
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  add_scene_input(app, options);
  add_volume_options(app, options);
  add_camera_options(app, options);
  add_sampling_options(app, options);
  add_lighting_options(app, options.lighting);
  add_animation_options(app, options.animation);
  add_explain_options(app, options);
  add_checkpoint_options(app, options);
  add_plan_options(app, options.plan, "a picture");
  add_host_options(app);
  add_board_options(app, options.board, true);
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  check_output(options);
  check_animation(options.animation);
  check_explain_options(options);
  check_checkpoint_options(options);
  check_plan_options(app, options);
  return options;
}

Scene scene_at(const Scene& input, const RenderOptions& options, double time) {
  Scene scene = at_time(input, time);
  if (!options.camera_name.empty()) choose_camera(scene, options.camera_name);
  set_camera(options.camera, scene.camera);
  if (options.light) scene.light = options.light;
  set_view(options, scene.view);
  set_lighting(options.lighting, scene);
  if (options.board.seed != 0) {
    const auto seed = static_cast<std::uint32_t>(options.board.seed);
    scene.view.seed = scene.lighting.settings.seed = seed;
  }
  return scene;
}

Scene scene_of(const RenderOptions& options) {
  return scene_at(input_scene(options), options, options.animation.start.value_or(0));
}

void set_phong(const RenderOptions& options, Phong& phong) {
  phong.ambient = options.ambient.value_or(phong.ambient);
  phong.diffuse = options.diffuse.value_or(phong.diffuse);
  phong.specular = options.specular.value_or(phong.specular);
  phong.shininess = options.shininess.value_or(phong.shininess);
}

}  // namespace gicube::samples

#include "scene/program/scene_input.h"

#include <fmt/format.h>

#include <algorithm>

#include "gicube/scene/transfer_function_file.h"
#include "scene/common/checks.h"
#include "scene/program/option_group.h"

namespace gicube::samples {

namespace {

void set_volume_size(const SceneInput& input, Scene& scene) {
  if (!scene.world && scene.volume.builtin.empty()) {
    throw UsageError("--volume-size: only for a built-in volume or a world; " + in_quotes(input.input) +
                     " has its own size");
  }
  if (!scene.world && *input.volume_size < kMinBuckyballSize) {
    throw UsageError(fmt::format("--volume-size: expected {} to {}, got {}", kMinBuckyballSize, kMaxBuckyballSize,
                                 *input.volume_size));
  }
  (scene.world ? scene.world->size : scene.volume.size) = *input.volume_size;
}

void set_volume_file(const SceneInput& input, Scene& scene) {
  VolumeSource& volume = scene.volume;
  const bool any = !input.part.empty() || input.as_stored || input.nan;
  if (any && (scene.world || !volume.builtin.empty()))
    throw UsageError("--part, --as-stored, --nan: only for a volume's file");
  if (!input.part.empty()) volume.part = input.part;
  volume.as_stored = volume.as_stored || input.as_stored;
  if (input.nan) volume.nan = input.nan;
}

}  // namespace

std::string preset_lines() {
  std::string lines;
  for (const Preset& preset : presets()) {
    const std::string_view comment = preset.text.substr(0, preset.text.find('\n'));
    lines += fmt::format("  {:<14}{}\n", preset.name, comment.substr(std::min<std::size_t>(2, comment.size())));
  }
  return lines;
}

Scene read_input(const std::string& input, bool allow_outside) {
  Scene scene;
  if (input.starts_with(kBuiltin)) {
    scene.volume.builtin = input.substr(std::string(kBuiltin).size());
  } else if (is_scene_path(input)) {
    scene = read_scene(input, allow_outside);
  } else {
    scene.volume.file = input;
    scene.volume.allow_outside = allow_outside;
  }
  return scene;
}

void add_scene_input(CLI::App& app, SceneInput& input) {
  app.add_option("INPUT", input.input,
                 "a scene (.scene .textproto .pbtxt .txt), builtin:buckyball, a volume file, or a folder of DICOM or "
                 "slices")
      ->required();
  OptionGroup group(app, "Scene");
  group
      .value("--volume-size", input.volume_size, "voxels along the longest edge of a world or a built-in volume (256)")
      ->check(CLI::Range(kMinWorldSize, kMaxWorldSize));
  group
      .value("--transfer-function", input.transfer_function,
             "of all materials: a file, auto (a preset chosen from the values of a volume file), or a preset: " +
                 preset_names())
      ->type_name("FILE|NAME");
  group
      .value("--part", input.part,
             "volume to read from a file or folder with several; without it, the error or a warning lists them")
      ->type_name("NAME|N");
  group.flag("--as-stored", input.as_stored, "keep the axes as stored, and ignore the directions in the file");
  group.value("--nan", input.nan, "value that replaces samples that are not finite")->type_name("VALUE");
  group.flag("--allow-outside", input.allow_outside, "headers and scenes may name files outside their folders");
}

Scene input_scene(const SceneInput& input) {
  if (input.input.starts_with(kBuiltin) && input.input != "builtin:buckyball") {
    throw UsageError("INPUT: expected builtin:buckyball, got " + in_quotes(input.input));
  }
  Scene scene = read_input(input.input, input.allow_outside);
  if (input.volume_size) set_volume_size(input, scene);
  if (!input.transfer_function.empty() && input.transfer_function != kAutomatic)
    scene.transfer_function = find_transfer_function(input.transfer_function);
  set_volume_file(input, scene);
  if (input.allow_outside) allow_outside(scene);
  return scene;
}

Scene scene_of(const SceneInput& input) { return at_time(input_scene(input), 0); }

}  // namespace gicube::samples

#include "scene/program/scene_input.h"

#include <fmt/format.h>

#include <algorithm>

#include "gicube/scene/transfer_function_file.h"
#include "scene/program/option_group.h"

namespace gicube::samples {

void add_volume_file_options(OptionGroup& group, VolumeFileOptions& options) {
  group
      .value("--part", options.part,
             "which volume of a file or folder that has several; without it, the error or a warning lists them")
      ->type_name("NAME|N");
  group.flag("--as-stored", options.as_stored,
             "leave axes as the file stores them, whatever it says of left, back and up");
  group.value("--nan", options.nan, "this value in place of samples that are no finite numbers")->type_name("VALUE");
}

void set_volume_file(const VolumeFileOptions& options, Scene& scene) {
  VolumeSource& volume = scene.volume;
  const bool any = !options.part.empty() || options.as_stored || options.nan;
  if (any && (scene.world || !volume.builtin.empty()))
    throw UsageError("--part, --as-stored, --nan: only for a volume's file");
  if (!options.part.empty()) volume.part = options.part;
  volume.as_stored = volume.as_stored || options.as_stored;
  if (options.nan) volume.nan = options.nan;
}

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
                 "a scene (.scene .textproto .pbtxt .txt), builtin:buckyball, or a volume file with a header")
      ->required();
  OptionGroup group(app, "Scene");
  group.value("--volume-size", input.volume_size, "voxels along the longest edge of a world or built-in volume")
      ->check(CLI::Range(kMinWorldSize, kMaxWorldSize));
  group
      .value("--transfer-function", input.transfer_function,
             "of all materials: a file, auto (a preset that the values of a volume file suggest), or a preset: " +
                 preset_names())
      ->type_name("FILE|NAME");
  add_volume_file_options(group, input.file);
  group.flag("--allow-outside", input.allow_outside, "let headers and scenes name files outside of their folders");
}

Scene scene_of(const SceneInput& input) {
  Scene scene = at_time(read_input(input.input, input.allow_outside), 0);
  if (input.volume_size) {
    if (!scene.world && scene.volume.builtin.empty()) {
      throw UsageError("--volume-size: only for a built-in volume or a world; " + in_quotes(input.input) +
                       " has its own size");
    }
    (scene.world ? scene.world->size : scene.volume.size) = *input.volume_size;
  }
  if (!input.transfer_function.empty() && input.transfer_function != kAutomatic)
    scene.transfer_function = find_transfer_function(input.transfer_function);
  set_volume_file(input.file, scene);
  if (input.allow_outside) allow_outside(scene);
  return scene;
}

}  // namespace gicube::samples

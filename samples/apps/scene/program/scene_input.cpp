#include "scene/program/scene_input.h"

#include "scene/program/option_group.h"

namespace gicube::samples {

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
  if (input.allow_outside) allow_outside(scene);
  return scene;
}

}  // namespace gicube::samples

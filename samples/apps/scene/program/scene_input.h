// The scene that a program is given, and the options that change it.
#pragma once

#include <optional>
#include <string>

#include "gicube/scene/scene.h"
#include "scene/names.h"

namespace CLI {
class App;
}

namespace gicube::samples {

class OptionGroup;

inline constexpr const char* kBuiltin = "builtin:";
inline constexpr const char* kAutomatic = "auto";  // a look that the values of a volume file suggest

// How a volume's file is read, in place of what the scene says.
struct VolumeFileOptions {
  std::string part;  // as VolumeSource has these
  bool as_stored = false;
  std::optional<double> nan;
};
// Adds --part --as-stored --nan.
void add_volume_file_options(OptionGroup& group, VolumeFileOptions& options);
// Throws UsageError: the scene has no volume file.
void set_volume_file(const VolumeFileOptions& options, Scene& scene);

// A line for each preset: its name, and the data that it is for.
std::string preset_lines();

// Reads a scene file, builtin:NAME or a volume file; engines are left as they are. Throws InputError.
Scene read_input(const std::string& input, bool allow_outside);

struct SceneInput {
  std::string input;  // as of read_input()
  std::optional<int> volume_size;
  std::string transfer_function;  // empty, auto: the scene's
  VolumeFileOptions file;
  bool allow_outside = false;
};

// Adds INPUT, and as the group "Scene" --volume-size --transfer-function --part --as-stored --nan --allow-outside.
void add_scene_input(CLI::App& app, SceneInput& input);
// The scene at the time 0 with these options. Throws UsageError, InputError.
Scene scene_of(const SceneInput& input);

}  // namespace gicube::samples

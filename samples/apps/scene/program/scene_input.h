// The scene of a program, and the options that change it.
#pragma once

#include <optional>
#include <string>

#include "gicube/scene/scene.h"
#include "scene/names.h"

namespace CLI {
class App;
}

namespace gicube::samples {

inline constexpr const char* kBuiltin = "builtin:";
inline constexpr const char* kAutomatic = "auto";  // a look chosen from the values of a volume file

// A line for each preset: its name, and the data for which it is made.
std::string preset_lines();

// Reads a scene file, builtin:NAME or a volume file; engines are not applied. Throws InputError.
Scene read_input(const std::string& input, bool allow_outside);

struct SceneInput {
  std::string input;  // as of read_input()
  std::optional<int> volume_size;
  std::string transfer_function;  // empty, auto: the scene's
  std::string part;               // these three as in VolumeSource
  bool as_stored = false;
  std::optional<double> nan;
  bool allow_outside = false;
};

// Adds INPUT, and as the group "Scene" --volume-size --transfer-function --part --as-stored --nan --allow-outside.
void add_scene_input(CLI::App& app, SceneInput& input);
// The scene with these options; engines are not applied. Throws UsageError (options that contradict the input),
// InputError (a scene or transfer function file).
Scene input_scene(const SceneInput& input);
// That scene at the time 0.
Scene scene_of(const SceneInput& input);

}  // namespace gicube::samples

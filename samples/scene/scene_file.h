// Scenes as protobuf text files (proto/gicube/v1/scene.proto).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace gicube::samples {

// Strict: an unknown field, a value of the wrong type, out of range or missing is an error. Throws InputError with all
// faults, one a line: "NAME:LINE:COLUMN: ..." for the text, "NAME: field.path: expected ..., got ..." for its meaning.
// Relative paths in `text` are taken from `folder`. Reads transfer functions, but not the volume.
Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder);
// The same for a file. Throws InputError also if it can't be read.
Scene read_scene(const std::filesystem::path& path);

// Whether a path's extension is that of a scene: .scene, .textproto, .pbtxt or .txt.
bool is_scene_path(const std::filesystem::path& path);

}  // namespace gicube::samples

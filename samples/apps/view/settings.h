// Settings of a view as gicube-render's options, and back as text for people.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "gicube/scene/image_file.h"
#include "gicube/scene/scene.h"
#include "render/options.h"
#include "view/request.h"

namespace gicube::samples::view {

// Files that a page may name, and nothing else of this machine.
struct Shelf {
  std::map<std::string, std::string> inputs;               // name to path, or builtin:NAME
  std::map<std::string, std::filesystem::path> functions;  // transfer functions
  std::filesystem::path folder;                            // for those that a page writes itself
};

// A file with a transfer function's text, by its content. Throws InputError: it is none; FileError: it can't be
// written.
std::filesystem::path file_of(const std::string& function, const Shelf& shelf);

// `board`: of the program's command line; a page may change its level and fields. Throws UsageError ("--NAME: expected
// ..., got ...") and InputError, FileError.
RenderOptions options_of(const Settings& settings, const Shelf& shelf, const BoardOptions& board);

// The gicube-render that makes the same picture; a transfer function that a page wrote is "view.tf".
std::string command_of(const Settings& settings, const Shelf& shelf, const BoardOptions& board);

// The lines of Python that do. Empty: the package has no call for what is set.
// `setup`, `background`: of the picture.
std::string python_of(const Settings& settings, const Shelf& shelf, const RenderOptions& options,
                      const SceneSetup& setup, const std::optional<Background>& background);

// Hello's settings of a view without settings: the program's choices, in the scene's units.
Settings chosen_settings(const SceneSetup& setup);

// The option at fault in a text that begins with its name and a colon, without dashes; or "".
std::string field_of(const std::string& text);

}  // namespace gicube::samples::view

// Settings of a view as options of gicube-render, as a command line, and as Python.
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

// The only files of this machine that a page may name.
struct Shelf {
  std::map<std::string, std::string> inputs;               // name to path, or builtin:NAME
  std::map<std::string, std::filesystem::path> functions;  // transfer functions
  std::filesystem::path folder;                            // for transfer functions written by a page
};

// A file with the text of a transfer function; the name is a hash of it. Throws InputError: the text is invalid;
// FileError: the file cannot be written.
std::filesystem::path file_of(const std::string& function, const Shelf& shelf);

// `board`: from the program's command line; a page may change its level and fields. Throws UsageError ("--NAME:
// expected ..., got ..."), InputError and FileError.
RenderOptions options_of(const Settings& settings, const Shelf& shelf, const BoardOptions& board);

// The command line of gicube-render for the same picture. A transfer function written by a page is named "view.tf".
std::string command_of(const Settings& settings, const Shelf& shelf, const BoardOptions& board);

// Python code for the same picture. Empty: the package has no call for a setting. `setup`, `background`: of the
// picture.
std::string python_of(const Settings& settings, const Shelf& shelf, const RenderOptions& options,
                      const SceneSetup& setup, const std::optional<Background>& background);

// The settings that the program chooses for a view without settings, in the scene's units, for the message "hello".
Settings chosen_settings(const SceneSetup& setup);

// The option, without dashes, in an error text that begins with it; otherwise "".
std::string field_of(const std::string& text);

}  // namespace gicube::samples::view

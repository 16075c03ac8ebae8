#include "view/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <ranges>
#include <span>
#include <sstream>
#include <vector>

#include "gicube/scene/error.h"
#include "gicube/scene/provenance.h"
#include "gicube/scene/transfer_function_file.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/program/scene_input.h"

namespace gicube::samples::view {
namespace {

// Settings that a page may send. Files, other outputs, plans and parts of a volume need a command line.
constexpr std::array kOptions{
    "ambient", "background", "big-endian",   "camera",     "colour-passes", "composite",
    "cut",     "diffuse",    "dims",         "exposure",   "eye",           "fidelity",
    "filter",  "fov",        "illumination", "input",      "jitter",        "lifetime",
    "light",   "light-rays", "look-at",      "no-leap",    "no-shade",      "orthographic",
    "rules",   "samples",    "seed",         "shininess",  "size",          "skip",
    "spacing", "specular",   "step",         "threshold",  "time",          "transfer-function",
    "range",   "type",       "up",           "volume-size"};
constexpr std::array kFlags{"big-endian", "colour-passes", "jitter", "no-leap", "no-shade"};

bool is_field(const std::string& name) { return name.find('.') != std::string::npos; }

std::string names_of(const auto& map) {
  std::string text;
  for (const auto& [name, value] : map) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// The input's path for gicube-render.
std::string path_of(const std::string& name, const Shelf& shelf) {
  const auto found = shelf.inputs.find(name);
  if (found == shelf.inputs.end())
    throw UsageError("--input: expected one of " + names_of(shelf.inputs) + ", got " + in_quotes(name));
  return found->second;
}

// The path as a user would type it: posted files have their own names.
std::string shown_path(const std::string& name, const Shelf& shelf) {
  std::string path = path_of(name, shelf);
  if (!path.starts_with(shelf.folder.string())) return path;
  return name.starts_with("builtin:") ? "./" + name : name;
}

// Protects a name that begins like an option.
std::string as_word(const std::string& path) { return path.starts_with('-') ? "./" + path : path; }

bool is_written(const std::string& function) { return function.find('\n') != std::string::npos; }

std::string function_path(const std::string& value, const Shelf& shelf) {
  if (is_written(value)) return file_of(value, shelf).string();
  const auto found = shelf.functions.find(value);
  if (found != shelf.functions.end()) return found->second.string();
  if (value == kAutomatic) return value;
  find_preset(value);  // throws for an unknown name
  return value;
}

// Arguments for gicube-render; `shown`: for users, with other names for files that exist only in this run.
std::vector<std::string> arguments_of(const Settings& settings, const Shelf& shelf, const BoardOptions& board,
                                      bool shown) {
  const auto input = settings.find("input");
  if (input == settings.end()) throw UsageError("--input: expected one of " + names_of(shelf.inputs) + ", got none");
  std::vector<std::string> words{as_word(shown ? shown_path(input->second, shelf) : path_of(input->second, shelf))};
  if (shown) {
    if (board.board != "emu:") words.push_back("--board=" + board.board);
    if (!board.fidelity.empty() && !settings.contains("fidelity")) words.push_back("--fidelity=" + board.fidelity);
    if (!board.config.empty()) words.push_back("--config=" + board.config.string());
    for (const std::string& field : board.settings) words.push_back("--set=" + field);
    if (board.seed != 0 && !settings.contains("seed")) words.push_back(fmt::format("--seed={}", board.seed));
  }
  for (const auto& [name, value] : settings) {
    if (name == "input") continue;
    if (is_field(name)) {
      words.push_back("--set=" + name + "=" + value);
    } else if (std::ranges::find(kOptions, name) == kOptions.end()) {
      throw UsageError("--" + name + ": expected a setting of a view (" + fmt::format("{}", fmt::join(kOptions, ", ")) +
                       ", or a field of the board's configuration)");
    } else if (std::ranges::find(kFlags, name) != kFlags.end()) {
      if (value != "on" && value != "off")
        throw UsageError("--" + name + ": expected on or off, got " + in_quotes(value));
      if (value == "on") words.push_back("--" + name);
    } else if (name == "cut") {
      for (const auto plane : std::views::split(value, ';')) {
        if (!plane.empty()) words.push_back("--cut=" + std::string(plane.begin(), plane.end()));
      }
    } else if (name == "transfer-function") {
      const bool own = shown && (is_written(value) || shelf.functions.contains(value));
      words.push_back("--transfer-function=" +
                      (own ? is_written(value) ? "view.tf" : value : function_path(value, shelf)));
    } else {
      words.push_back("--" + name + "=" + value);
    }
  }
  return words;
}

std::string text_of(const Vec3& v) { return fmt::format("{},{},{}", v.x, v.y, v.z); }

}  // namespace

std::filesystem::path file_of(const std::string& function, const Shelf& shelf) {
  parse_transfer_function(function, "transfer-function");
  const auto bytes = std::as_bytes(std::span(function.data(), function.size()));
  std::filesystem::path file = shelf.folder / (".tf-" + hex(hash_of(bytes)) + ".tf");
  if (!std::filesystem::exists(file)) scene::write_whole(file, function);
  return file;
}

RenderOptions options_of(const Settings& settings, const Shelf& shelf, const BoardOptions& board) {
  std::vector<std::string> words = arguments_of(settings, shelf, board, false);
  words.insert(words.begin(), "gicube-render");
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  std::ostringstream out;
  auto options = samples::parse_options(static_cast<int>(argv.size()), argv.data(), out);
  if (!options) throw UsageError("--help: expected a setting of a view");
  BoardOptions own = board;
  if (!options->board.fidelity.empty()) own.fidelity = options->board.fidelity;
  for (const std::string& field : options->board.settings) own.settings.push_back(field);
  if (settings.contains("seed")) own.seed = options->board.seed;
  options->board = own;
  return *options;
}

std::string command_of(const Settings& settings, const Shelf& shelf, const BoardOptions& board) {
  std::vector<std::string> words = arguments_of(settings, shelf, board, true);
  words.insert(words.begin(), "gicube-render");
  words.insert(words.end(), {"-o", "picture.png"});
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  return command_line(static_cast<int>(argv.size()), argv.data());
}

std::string python_of(const Settings& settings, const Shelf& shelf, const RenderOptions& options,
                      const SceneSetup& setup, const std::optional<Background>& background) {
  for (const char* without : {"illumination", "rules", "light-rays", "lifetime", "colour-passes", "dims", "type",
                              "big-endian", "skip", "composite"}) {
    if (settings.contains(without)) return "";
  }
  if (std::ranges::any_of(settings, [](const auto& setting) { return !is_utf8(setting.second); })) return "";
  if (setup.lighting.colour_passes || !options.board.board.starts_with("emu:")) return "";
  const std::string input = nlohmann::json(shown_path(settings.at("input"), shelf)).dump();
  std::string scene = "gicube.read_scene(" + input + ")";
  if (!is_scene_path(options.input)) {
    const std::string builtin = "builtin:";
    // The scene is in the file's folder, since a scene names no file outside its own.
    std::filesystem::path file = shown_path(settings.at("input"), shelf);
    if (!file.has_filename()) file = file.parent_path();
    std::string volume = "file: " + nlohmann::json(file.filename().string()).dump(), folder;
    if (options.input.starts_with(builtin)) {
      volume = "builtin: \"" + options.input.substr(builtin.size()) + '"';
    } else if (file.has_parent_path()) {
      folder = ", folder=" + nlohmann::json(file.parent_path().string()).dump();
    }
    if (options.volume_size) volume += fmt::format(" size: {}", *options.volume_size);
    if (options.spacing) volume += fmt::format(" spacing: [{}]", text_of(*options.spacing));
    scene = "gicube.parse_scene(" + nlohmann::json("volume { " + volume + " }").dump() + folder + ")";
  } else if (options.volume_size) {
    return "";
  }
  const auto vector = [](const Vec3& v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); };
  const auto word = [](bool is) { return is ? "True" : "False"; };
  const View& view = setup.view;
  const Phong& phong = setup.shading.phong;
  std::string text = "import dataclasses\n\nimport gicube\n\nscene = " + scene;
  if (options.animation.start) text += fmt::format(".at_time({})", *options.animation.start);
  const auto look = settings.find("transfer-function");
  if (look != settings.end() && look->second != kAutomatic) {
    const std::string name = is_written(look->second) ? "view.tf" : look->second;
    text += "\nscene.set_transfer_function(" + nlohmann::json(name).dump() + ")";
  }
  if (options.range) text += fmt::format("\nscene.set_range({}, {})", options.range->low, options.range->high);
  text +=
      "\nsetup = scene.set_up()\nwith gicube.open(" + nlohmann::json(board_uri(options.board)).dump() + ") as board:\n";
  text += "    view = gicube.load_scene(board, setup)\n";
  text += fmt::format("    phong = gicube.Phong({}, {}, {}, {})\n", phong.ambient, phong.diffuse, phong.specular,
                      phong.shininess);
  text += "    board.set_shading(gicube.Shading(phong, " + vector(setup.shading.light) + "))\n";
  std::string planes;
  for (const CutPlane& plane : view.cut_planes) {
    planes += fmt::format("gicube.CutPlane({}, {}), ", vector(plane.normal), plane.offset);
  }
  text += "    view = dataclasses.replace(\n        view,\n";
  text += fmt::format("        eye={},\n        look_at={},\n        up={},\n", vector(view.eye), vector(view.look_at),
                      vector(view.up));
  text +=
      fmt::format("        fov_degrees={},\n        orthographic_height={},\n        width={},\n        height={},\n",
                  view.fov_degrees, view.orthographic_height, view.width, view.height);
  text += fmt::format("        samples_per_axis={},\n        filter=gicube.PixelFilter.{},\n        step={},\n",
                      view.samples_per_axis, view.filter == PixelFilter::kBox ? "BOX" : "TENT", view.step);
  text += fmt::format("        opacity_threshold={},\n        shade={},\n        jitter={},\n        leap={},\n",
                      view.opacity_threshold, word(view.shade), word(view.jitter), word(view.leap));
  text += fmt::format("        exposure={},\n        seed={},\n        cut_planes=[{}],\n    )\n",
                      setup.lighting.exposure, view.seed, planes);
  std::string over;
  if (background)
    over =
        fmt::format(", background=({}, {}, {})", background->colour[0], background->colour[1], background->colour[2]);
  return text + "    board.render(view).save(\"picture.png\"" + over + ")\n";
}

Settings chosen_settings(const SceneSetup& setup) {
  const auto outside = [&setup](const Vec3& p) { return setup.grid.low + setup.grid.voxel * p; };
  const View& view = setup.view;
  Settings settings{{"eye", text_of(outside(view.eye))},
                    {"look-at", text_of(outside(view.look_at))},
                    {"up", text_of(view.up)},
                    {"size", fmt::format("{}x{}", view.width, view.height)},
                    {"step", fmt::format("{}", view.step)},
                    {"threshold", fmt::format("{}", view.opacity_threshold)}};
  if (view.orthographic_height > 0) {
    settings["orthographic"] = fmt::format("{}", view.orthographic_height * setup.grid.voxel);
  } else {
    settings["fov"] = fmt::format("{}", view.fov_degrees);
  }
  return settings;
}

std::string field_of(const std::string& text) {
  if (!text.starts_with("--")) return "";
  return text.substr(2, text.find_first_of(": ,=") - 2);
}

}  // namespace gicube::samples::view

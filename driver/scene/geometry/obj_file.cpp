#include <ranges>
#include <string>

#include "scene/common/checks.h"
#include "scene/geometry/mesh_file.h"

namespace gicube::scene {
namespace {

using Words = std::vector<std::string_view>;  // of a statement, its keyword first

struct ObjReader {
  const std::filesystem::path& file;
  Mesh mesh{};
  std::size_t line_number = 0;

  Mesh read(std::string_view text) {
    std::string joined;  // lines that end with a backslash, and the one after them
    for (const auto part : std::views::split(text, '\n')) {
      std::string_view line(part.begin(), part.end());
      ++line_number;
      line = line.substr(0, line.find('#'));
      if (line.ends_with('\r')) line.remove_suffix(1);
      if (line.ends_with('\\')) {
        joined.append(line.substr(0, line.size() - 1)) += ' ';
        continue;
      }
      const Words words = words_of(joined.empty() ? line : std::string_view(joined += line));
      if (!words.empty() && words[0] == "v") point(words);
      if (!words.empty() && words[0] == "vt") texture_point(words);
      if (!words.empty() && words[0] == "f") face(words);
      joined.clear();
    }
    if (!joined.empty()) fail("statement", "a line after the backslash", "the end");
    if (mesh.triangles.empty()) throw FileError(file, "faces", "at least one", "none");
    if (mesh.texture_triangles.size() != mesh.triangles.size()) mesh.texture = {}, mesh.texture_triangles = {};
    return std::move(mesh);
  }

  [[noreturn]] void fail(const std::string& field, const std::string& expected, const std::string& got) const {
    throw FileError(file, fmt::format("line {}: {}", line_number, field), expected, got);
  }

  // The first numbers of a statement. A point's weight and colour, and a texture's third coordinate, are not used.
  template <std::size_t Count>
  std::array<double, Count> numbers(const Words& words, const char* expected) const {
    std::array<double, Count> values{};
    for (std::size_t i = 0; i < Count; ++i) {
      const std::string_view word = i + 1 < words.size() ? words[i + 1] : "";
      const auto number = parse_number<double>(word);
      if (!number || !std::isfinite(*number)) fail(std::string(words[0]), expected, in_quotes(word));
      values[i] = *number;
    }
    return values;
  }

  void point(const Words& words) {
    const auto [x, y, z] = numbers<3>(words, "three finite numbers");
    mesh.points.push_back({x, y, z});
  }
  void texture_point(const Words& words) { mesh.texture.push_back(numbers<2>(words, "two finite numbers")); }

  // "7" or "-1" as an index among `count`, in a corner's `word`.
  std::uint32_t index(std::string_view part, std::size_t count, const char* what, std::string_view word) const {
    const auto number = parse_number<std::int64_t>(part);
    const auto all = static_cast<std::int64_t>(count);
    if (!number || *number == 0 || *number > all || *number < -all) {
      fail("f", fmt::format("a {} from 1 to {}", what, all), in_quotes(word));
    }
    return static_cast<std::uint32_t>(*number > 0 ? *number - 1 : all + *number);
  }

  // Corners are "7", "7/1", "7/1/3" or "7//3": point, texture coordinates, normal.
  void face(const Words& words) {
    std::vector<std::uint32_t> corners, texture;
    for (const std::string_view word : words | std::views::drop(1)) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      corners.push_back(index(word.substr(0, slash), mesh.points.size(), "point", word));
      std::string_view second = word.substr(std::min(slash + 1, word.size()));
      second = second.substr(0, second.find('/'));
      if (!second.empty()) texture.push_back(index(second, mesh.texture.size(), "texture coordinate", word));
    }
    if (corners.size() < 3) fail("f", "at least 3 corners", std::to_string(corners.size()));
    if (!add_fan(corners, mesh)) fail("f", fmt::format("at most {}", kMaxTriangles), "more");
    if (texture.size() != corners.size()) return;
    for (std::size_t i = 2; i < texture.size(); ++i) {
      mesh.texture_triangles.push_back({texture[0], texture[i - 1], texture[i]});
    }
  }
};

}  // namespace

Mesh parse_obj(std::string_view text, const std::filesystem::path& name) { return ObjReader{name}.read(text); }

}  // namespace gicube::scene

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
    for (const auto part : std::views::split(text, '\n')) {
      const std::string_view line(part.begin(), part.end());
      ++line_number;
      const Words words = words_of(line.substr(0, line.find('#')));
      if (!words.empty() && words[0] == "v") point(words);
      if (!words.empty() && words[0] == "f") face(words);
    }
    if (mesh.triangles.empty()) throw FileError(file, "faces", "at least one", "none");
    return std::move(mesh);
  }

  [[noreturn]] void fail(const std::string& field, const std::string& expected, const std::string& got) const {
    throw FileError(file, fmt::format("line {}: {}", line_number, field), expected, got);
  }

  void point(const Words& words) {
    double values[3];
    for (std::size_t i = 0; i < 3; ++i) {  // a fourth one, the weight, and vertex colours are of no use here
      const std::string_view word = i + 1 < words.size() ? words[i + 1] : "";
      const auto number = parse_number<double>(word);
      if (!number || !std::isfinite(*number)) fail("v", "three finite numbers", in_quotes(word));
      values[i] = *number;
    }
    mesh.points.push_back({values[0], values[1], values[2]});
  }

  // "7", "7/1", "7//3" or "-1/..."; only the first number counts.
  std::uint32_t corner(std::string_view word) const {
    const auto number = parse_number<std::int64_t>(word.substr(0, word.find('/')));
    const auto points = static_cast<std::int64_t>(mesh.points.size());
    if (!number || *number == 0 || *number > points || *number < -points) {
      fail("f", fmt::format("a point from 1 to {}", points), in_quotes(word));
    }
    return static_cast<std::uint32_t>(*number > 0 ? *number - 1 : points + *number);
  }

  void face(const Words& words) {
    std::vector<std::uint32_t> corners;
    for (const std::string_view word : words | std::views::drop(1)) corners.push_back(corner(word));
    if (corners.size() < 3) fail("f", "at least 3 corners", std::to_string(corners.size()));
    if (!add_fan(corners, mesh)) fail("f", fmt::format("at most {}", kMaxTriangles), "more");
  }
};

}  // namespace

Mesh parse_obj(std::string_view text, const std::filesystem::path& name) { return ObjReader{name}.read(text); }

}  // namespace gicube::scene

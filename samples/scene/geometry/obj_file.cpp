#include <cmath>
#include <string>

#include "scene/geometry/mesh_file.h"
#include "scene/program/checks.h"

namespace gicube::samples {
namespace {

constexpr std::string_view kBlank = " \t\r";

// Cuts the next word off `line`; empty at its end.
std::string_view next_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlank));
  line.remove_prefix(word.size());
  return word;
}

class ObjReader {
 public:
  explicit ObjReader(const std::filesystem::path& name) : name_(name) {}

  void statement(std::string_view line) {
    ++line_;
    line = line.substr(0, line.find('#'));
    const std::string_view keyword = next_word(line);
    if (keyword == "v") point(line);
    if (keyword == "f") face(line);
  }

  Mesh finish() {
    if (mesh_.triangles.empty()) throw FileError(name_, "faces", "at least one", "none");
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& field, const std::string& expected, const std::string& got) const {
    throw FileError(name_, "line " + std::to_string(line_) + ": " + field, expected, got);
  }

  void point(std::string_view line) {
    double values[3];
    for (double& value : values) {  // a fourth one, the weight, and vertex colours are of no use here
      const std::string_view word = next_word(line);
      const auto number = parse_number<double>(word);
      if (!number || !std::isfinite(*number)) fail("v", "three finite numbers", in_quotes(word));
      value = *number;
    }
    mesh_.points.push_back({values[0], values[1], values[2]});
  }

  // "7", "7/1", "7//3" or "-1/..."; only the first number counts.
  std::uint32_t corner(std::string_view word) const {
    const auto number = parse_number<std::int64_t>(word.substr(0, word.find('/')));
    const auto points = static_cast<std::int64_t>(mesh_.points.size());
    if (!number || *number == 0 || *number > points || *number < -points) {
      fail("f", "a point from 1 to " + std::to_string(points), in_quotes(word));
    }
    return static_cast<std::uint32_t>(*number > 0 ? *number - 1 : points + *number);
  }

  void face(std::string_view line) {
    std::uint32_t first = 0, last = 0;
    int corners = 0;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line), ++corners) {
      const std::uint32_t next = corner(word);
      if (corners == 0) first = next;
      if (corners >= 2) {
        if (mesh_.triangles.size() >= kMaxTriangles) fail("f", "at most " + std::to_string(kMaxTriangles), "more");
        mesh_.triangles.push_back({first, last, next});
      }
      last = next;
    }
    if (corners < 3) fail("f", "at least 3 corners", std::to_string(corners));
  }

  const std::filesystem::path& name_;
  Mesh mesh_;
  std::size_t line_ = 0;
};

}  // namespace

Mesh parse_obj(std::string_view text, const std::filesystem::path& name) {
  ObjReader reader(name);
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    reader.statement(line);
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
  return reader.finish();
}

}  // namespace gicube::samples

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <ranges>
#include <string>

#include "scene/common/checks.h"
#include "scene/formats/stored_samples.h"
#include "scene/geometry/mesh_file.h"

// G. Turk, "The PLY Polygon File Format", 1994.
namespace gicube::scene {
namespace {

enum class Format { kAscii, kLittle, kBig };
using Type = StoredType;

struct Property {
  std::string name;
  Type type = Type::kInt8;
  std::optional<Type> count;  // of a list's length
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

using Words = std::vector<std::string_view>;  // of a line

std::optional<Type> type_named(std::string_view name) {
  static const std::map<std::string_view, Type> kTypes{
      {"char", Type::kInt8},     {"int8", Type::kInt8},       {"uchar", Type::kUint8},    {"uint8", Type::kUint8},
      {"short", Type::kInt16},   {"int16", Type::kInt16},     {"ushort", Type::kUint16},  {"uint16", Type::kUint16},
      {"int", Type::kInt32},     {"int32", Type::kInt32},     {"uint", Type::kUint32},    {"uint32", Type::kUint32},
      {"float", Type::kFloat32}, {"float32", Type::kFloat32}, {"double", Type::kFloat64}, {"float64", Type::kFloat64}};
  const auto found = kTypes.find(name);
  return found != kTypes.end() ? std::optional(found->second) : std::nullopt;
}

struct PlyReader {
  std::string_view rest;
  const std::filesystem::path& file;
  Format format = Format::kAscii;
  std::vector<Element> elements{};
  Mesh mesh{};

  Mesh read() {
    header();
    for (const Element& element : elements) {
      check_size(element);
      for (std::uint64_t i = 0; i < element.count; ++i) item(element, i);
    }
    for (const std::uint32_t corner : mesh.triangles | std::views::join) {
      if (corner < mesh.points.size()) continue;
      fail("face", fmt::format("a vertex from 0 to {}", mesh.points.size() - 1), std::to_string(corner));
    }
    if (mesh.triangles.empty()) fail("faces", "at least one", "none");
    return std::move(mesh);
  }

  [[noreturn]] void fail(const std::string& field, const std::string& expected, const std::string& got) const {
    throw FileError(file, field, expected, got);
  }

  Words header_line() {
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos || end > 4096) fail("header", "end_header", "the end of the file");
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end + 1);
    return words_of(line);
  }

  void header() {
    if (header_line() != Words{"ply"}) fail("header", "ply in the first line", "something else");
    bool has_format = false;
    while (true) {
      const Words words = header_line();
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format") {
        set_format(words.size() > 1 ? words[1] : "");
        has_format = true;
      } else if (words[0] == "element") {
        add_element(words);
      } else if (words[0] == "property") {
        add_property(words);
      } else {
        fail("header", "format, element, property, comment or end_header", in_quotes(words[0]));
      }
    }
    if (!has_format) fail("header", "a format", "none");
    for (const Element& element : elements) check_element(element);
  }

  void set_format(std::string_view name) {
    if (name != "ascii" && name != "binary_little_endian" && name != "binary_big_endian") {
      fail("format", "ascii, binary_little_endian or binary_big_endian", in_quotes(name));
    }
    format = name == "ascii" ? Format::kAscii : name == "binary_big_endian" ? Format::kBig : Format::kLittle;
  }

  void add_element(const Words& words) {
    const auto count = words.size() == 3 ? parse_number<std::uint64_t>(words[2]) : std::nullopt;
    if (!count) fail("element", "a name and a count", words.size() > 1 ? in_quotes(words.back()) : "nothing");
    elements.push_back({std::string(words[1]), *count, {}});
  }

  void add_property(const Words& words) {
    if (elements.empty()) fail("property", "an element before it", "none");
    const bool list = words.size() == 5 && words[1] == "list";
    if (!list && words.size() != 3) fail("property", "TYPE NAME or list COUNT_TYPE TYPE NAME", "something else");
    const std::string_view name = words[words.size() - 2];
    const auto type = type_named(name), count = list ? type_named(words[2]) : std::nullopt;
    if (!type || (list && !count)) fail("property", "a type, char to double", in_quotes(name));
    if (count == Type::kFloat32 || count == Type::kFloat64) {
      fail("property", "a whole number as a list's count", in_quotes(words[2]));
    }
    elements.back().properties.push_back({std::string(words.back()), *type, count});
  }

  void check_element(const Element& element) const {
    if (element.count > 0 && element.properties.empty()) fail("element " + element.name, "properties", "none");
    for (const std::string axis : {"x", "y", "z"}) {
      const auto is_axis = [&](const Property& property) { return property.name == axis && !property.count; };
      if (element.name == "vertex" && std::ranges::none_of(element.properties, is_axis)) {
        fail("element vertex", "property " + axis, "none");
      }
    }
    if (element.name == "face" && std::ranges::none_of(element.properties, is_corner_list)) {
      fail("element face", "a list vertex_indices or vertex_index", "none");
    }
  }

  static bool is_corner_list(const Property& property) {
    return property.count && (property.name == "vertex_indices" || property.name == "vertex_index");
  }

  // The sizes in the header must fit the file: each value needs at least a digit and a blank, or its bytes.
  void check_size(const Element& element) const {
    std::uint64_t least = 0;
    for (const Property& property : element.properties) {
      least += format == Format::kAscii ? 2 : bytes_of(property.count.value_or(property.type));
    }
    if (element.count == 0 || element.count <= (rest.size() + 1) / least) return;
    fail("element " + element.name, fmt::format("at most {} that fit into the file", (rest.size() + 1) / least),
         std::to_string(element.count));
  }

  double value(Type type, const std::string& field) {
    return format == Format::kAscii ? ascii_value(field) : binary_value(type, field);
  }

  double ascii_value(const std::string& field) {
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n"), rest.size()));
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t\r\n"));
    if (word.empty()) fail(field, "a number", "the end of the file");
    const auto number = parse_number<double>(word);
    if (!number) fail(field, "a number", in_quotes(word.substr(0, 40)));
    rest.remove_prefix(word.size());
    return *number;
  }

  double binary_value(Type type, const std::string& field) {
    std::array<char, 8> bytes{};
    const std::size_t size = bytes_of(type);
    if (rest.size() < size) fail(field, std::to_string(size) + " bytes", "the end of the file");
    std::memcpy(bytes.data(), rest.data(), size);
    rest.remove_prefix(size);
    if ((format == Format::kBig) == (std::endian::native == std::endian::little)) {
      std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    }
    return with_sample(type, [&bytes](auto sample) {
      std::memcpy(&sample, bytes.data(), sizeof sample);
      return static_cast<double>(sample);
    });
  }

  void item(const Element& element, std::uint64_t index) {
    const std::string field = element.name + " " + std::to_string(index);
    Vec3 point;
    for (const Property& property : element.properties) {
      if (property.count) {
        list(property, field, element.name == "face" && is_corner_list(property));
        continue;
      }
      const double number = value(property.type, field);
      if (property.name == "x") point.x = number;
      if (property.name == "y") point.y = number;
      if (property.name == "z") point.z = number;
    }
    if (element.name != "vertex") return;
    if (!is_finite(point)) fail(field, "finite numbers", "another");
    mesh.points.push_back(point);
  }

  void list(const Property& property, const std::string& field, bool corners) {
    const double count = value(*property.count, field);
    if (!(count >= (corners ? 3 : 0)) || count > 1e9 || count != std::floor(count)) {
      fail(field, corners ? "at least 3 corners" : "a count", std::to_string(count));
    }
    std::vector<std::uint32_t> polygon;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(count);
         ++i) {  // ends with the file, even if the count is larger
      const double number = value(property.type, field);
      if (!corners) continue;
      if (!(number >= 0) || number >= 4294967295.0 || number != std::floor(number)) {
        fail(field, "the number of a vertex", std::to_string(number));
      }
      polygon.push_back(static_cast<std::uint32_t>(number));
    }
    if (corners && !add_fan(polygon, mesh)) fail(field, fmt::format("at most {}", kMaxTriangles), "more");
  }
};

}  // namespace

Mesh parse_ply(std::string_view bytes, const std::filesystem::path& name) { return PlyReader{bytes, name}.read(); }

}  // namespace gicube::scene

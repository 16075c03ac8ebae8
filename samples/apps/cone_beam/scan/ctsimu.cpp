#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cone_beam/scan/formats.h"
#include "scene/formats/data_stream.h"

namespace gicube::samples {
namespace {

constexpr int kMaxViews = 1 << 16, kMaxPixels = 1 << 16;  // chosen
constexpr double kMaxBytes = 1e15;                        // chosen: of a header
constexpr double kDegree = std::numbers::pi / 180;

// A JSON value with its path. Its functions throw FileError for a value that is missing, of another type or out of
// range.
struct JsonPart {
  std::filesystem::path file;
  std::string name;
  nlohmann::json json;

  [[noreturn]] void fault(const std::string& expected, const std::string& got) const {
    throw FileError(file, name.empty() ? "file" : name, expected, got);
  }
  [[noreturn]] void fault(const std::string& expected) const {
    const std::string got = json.dump();
    fault(expected, got.size() > 80 ? got.substr(0, 77) + "..." : got);
  }

  bool has(const std::string& key) const { return json.is_object() && json.contains(key) && !json[key].is_null(); }
  JsonPart at(const std::string& key) const {
    const std::string path = name.empty() ? key : name + "." + key;
    if (!json.is_object() || !json.contains(key)) throw FileError(file, path, "a value", "none");
    return {file, path, json[key]};
  }

  std::string text() const {
    if (!json.is_string()) fault("a text");
    return json.get<std::string>();
  }
  bool boolean() const {
    if (!json.is_boolean()) fault("true or false");
    return json.get<bool>();
  }
  double number() const {
    if (!json.is_number() || !std::isfinite(json.get<double>())) fault("a finite number");
    return json.get<double>();
  }
  int whole(int low, int high) const {
    const double value = json.is_number() ? json.get<double>() : low - 1.0;
    if (!(value >= low && value <= high) || value != std::floor(value)) {
      fault(fmt::format("a whole number from {} to {}", low, high));
    }
    return static_cast<int>(value);
  }

  // Value of {"value": .., "unit": ".."} or of a plain number, in millimetres, radians (the format's default is
  // degrees) or pixels.
  double length() const { return with_unit({{"mm", 1}, {"nm", 1e-6}, {"um", 1e-3}, {"cm", 10}, {"m", 1000}}); }
  double angle() const {
    const bool plain = json.is_number() || !has("unit");
    return (plain ? kDegree : 1) * with_unit({{"deg", kDegree}, {"rad", 1}});
  }
  int pixels() const {
    if (json.is_number()) return whole(1, kMaxPixels);
    if (has("unit") && at("unit").text() != "px") at("unit").fault("px");
    return at("value").whole(1, kMaxPixels);
  }

 private:
  double with_unit(const std::vector<std::pair<const char*, double>>& units) const {
    if (json.is_number()) return number();
    const double value = at("value").number();
    if (!has("unit")) return value;
    const JsonPart unit = at("unit");
    std::string known;
    for (const auto& [text, size] : units) {
      if (unit.text() == text) return value * size;
      known += (known.empty() ? "" : ", ") + std::string(text);
    }
    unit.fault("one of " + known);
  }
};

JsonPart read_json(const std::filesystem::path& file) {
  constexpr std::uint64_t kMaxSize = 16 << 20;  // chosen: far above any description of a scan
  constexpr int kMaxNesting = 100;              // chosen: copies and texts of deeper values would need much stack
  if (const auto bytes = file_bytes(file); bytes > kMaxSize) {
    throw FileError(file, "file", "at most 16 MiB", fmt::format("{} bytes", bytes));
  }
  std::ifstream stream(file);
  const auto check_depth = [&](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
    if (depth <= kMaxNesting) return true;
    throw FileError(file, "file", fmt::format("at most {} levels of nesting", kMaxNesting), "more");
  };
  try {
    return {file, "", nlohmann::json::parse(stream, check_depth)};
  } catch (const nlohmann::json::parse_error& error) {
    throw FileError(file, fmt::format("byte {}", error.byte), "JSON", error.what());
  } catch (const nlohmann::json::out_of_range& error) {
    throw FileError(file, "file", "numbers that a double holds", error.what());
  }
}

// A point: x, y and z are lengths.
Vec3 place(const JsonPart& part) { return {part.at("x").length(), part.at("y").length(), part.at("z").length()}; }

Vec3 direction(const JsonPart& part) {
  const auto number = [&](const char* key) {
    const JsonPart axis = part.at(key);
    return axis.has("value") ? axis.at("value").number() : axis.number();
  };
  const Vec3 v{number("x"), number("y"), number("z")};
  if (!(length(v) > 0)) part.fault("a direction");
  return (1 / length(v)) * v;
}

// Position and axes of a part of the machine: u and w from the file, v = w x u.
struct Stand {
  Vec3 centre, u, v, w;
};

Stand stand_of(const JsonPart& part) {
  if (part.has("deviations") && !part.at("deviations").json.empty()) {
    part.at("deviations").fault("none: machines that deviate from their geometry are not supported");
  }
  const Stand stand{place(part.at("center")), direction(part.at("vector_u")), {}, direction(part.at("vector_w"))};
  if (std::abs(dot(stand.u, stand.w)) > 1e-6) part.at("vector_u").fault("a direction perpendicular to vector_w");
  return {stand.centre, stand.u, cross(stand.w, stand.u), stand.w};
}

// The view after the stage has turned by `angle` from its position in the file, in the stage's own axes.
ViewPose pose_of(const Stand& source, const Stand& stage, const Stand& detector, double pitch_u, double pitch_v,
                 double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const auto turned = [&](Vec3 v) {
    const double x = dot(v, stage.u), y = dot(v, stage.v);
    return Vec3{c * x + s * y, c * y - s * x, dot(v, stage.w)};
  };
  return {turned(source.centre - stage.centre), turned(detector.centre - stage.centre), pitch_u * turned(detector.u),
          pitch_v * turned(detector.v)};
}

// Angles of the stage in the order of the views, radians.
std::vector<double> stage_angles(const JsonPart& acquisition) {
  const double start = acquisition.at("start_angle").angle(), stop = acquisition.at("stop_angle").angle();
  const int count = acquisition.at("number_of_projections").whole(2, kMaxViews);
  const bool last = acquisition.at("include_final_angle").boolean();
  const JsonPart direction = acquisition.at("direction");
  const std::string text = direction.text();
  if (text != "CCW" && text != "CW") direction.fault("\"CCW\" or \"CW\"");
  std::vector<double> angles;
  for (int i = 0; i < count; ++i) {
    const double angle = start + (stop - start) * i / (last ? count - 1 : count);
    angles.push_back(text == "CW" ? -angle : angle);
  }
  return angles;
}

ScanDescription read_scenario(const JsonPart& json) {
  const JsonPart geometry = json.at("geometry"), detector = json.at("detector");
  if (geometry.at("source").has("type") && geometry.at("source").at("type").text() != "cone") {
    geometry.at("source").at("type").fault("\"cone\"");
  }
  const Stand source = stand_of(geometry.at("source")), stage = stand_of(geometry.at("stage"));
  const int columns = detector.at("columns").pixels(), rows = detector.at("rows").pixels();
  const JsonPart pitch = detector.at("pixel_pitch");
  const double pitch_u = pitch.at("u").length(), pitch_v = pitch.at("v").length();
  if (!(pitch_u > 0)) pitch.at("u").fault("a length above 0");
  if (!(pitch_v > 0)) pitch.at("v").fault("a length above 0");
  ScanDescription out;
  out.geometry.detector.columns = columns;
  out.geometry.detector.rows = rows;
  std::vector<ViewPose> views;
  for (const double angle : stage_angles(json.at("acquisition"))) {
    views.push_back(pose_of(source, stage, stand_of(geometry.at("detector")), pitch_u, pitch_v, angle));
    check_view(views.back(), json.file, "geometry");
  }
  set_views(std::move(views), {}, out);
  out.file = json.file;
  return out;
}

RawLayout layout_of(const JsonPart& projections, int columns, int rows) {
  const JsonPart type = projections.at("datatype");
  RawLayout layout;
  layout.dims = {columns, rows, 0};
  if (!raw_type(type.text())) type.fault("uint8, uint16, int16 or float32");
  layout.type = *raw_type(type.text());
  if (projections.has("byteorder")) {
    const JsonPart order = projections.at("byteorder");
    if (order.text() != "little" && order.text() != "big") order.fault("\"little\" or \"big\"");
    layout.big_endian = order.text() == "big";
  }
  if (!projections.has("headersize")) return layout;
  const JsonPart header = projections.at("headersize");
  if (header.has("image") && header.at("image").number() != 0) header.at("image").fault("0");
  if (header.has("file")) {
    const double bytes = header.at("file").number();
    if (!(bytes >= 0 && bytes < kMaxBytes)) header.at("file").fault("a number of bytes");
    layout.skip_bytes = static_cast<std::uint64_t>(bytes);
  }
  return layout;
}

// A name with %04d names `count` files, from 0 on.
StackFiles files_of(const JsonPart& name, int count, const RawLayout& layout) {
  StackFiles out;
  out.raw = layout;
  const std::string text = name.text();
  const std::size_t percent = text.find('%');
  if (percent == std::string::npos) {
    out.files = {name.file.parent_path() / text};
    return out;
  }
  const std::size_t end = text.find('d', percent);
  const std::string digits = end == std::string::npos ? "x" : text.substr(percent + 1, end - percent - 1);
  const bool plain = digits.size() <= 2 && digits.find_first_not_of("0123456789") == std::string::npos;
  if (!plain || text.find('%', percent + 1) != std::string::npos) name.fault("one %d or %04d");
  const int width = digits.empty() ? 0 : std::stoi(digits);
  for (int i = 0; i < count; ++i) {
    out.files.push_back(name.file.parent_path() /
                        (text.substr(0, percent) + fmt::format("{:0{}}", i, width) + text.substr(end + 1)));
  }
  return out;
}

// Frames for the correction of the projections, empty if these are corrected.
StackFiles correction_of(const JsonPart& projections, const char* key, const RawLayout& layout) {
  if (!projections.has(key)) return {};
  const JsonPart field = projections.at(key);
  const bool corrected = field.has("projections_corrected") && field.at("projections_corrected").boolean();
  if (corrected || !field.has("filename") || !field.has("number")) return {};
  const int count = field.at("number").whole(0, kMaxViews);
  return count == 0 ? StackFiles{} : files_of(field.at("filename"), count, layout);
}

ScanDescription read_metadata(const JsonPart& json) {
  const JsonPart output = json.at("output"), projections = output.at("projections");
  const JsonPart scenario = json.at("acquisition_geometry").at("path_to_CTSimU_JSON");
  ScanDescription out = read_scenario(read_json(json.file.parent_path() / scenario.text()));
  out.file = json.file;
  const JsonPart size = projections.at("dimensions");
  const Detector& detector = out.geometry.detector;
  const int columns = size.at("x").pixels(), rows = size.at("y").pixels();
  if (columns != detector.columns || rows != detector.rows) {
    size.fault(fmt::format("{} x {}, as the scenario's detector has", detector.columns, detector.rows),
               fmt::format("{} x {}", columns, rows));
  }
  const RawLayout layout = layout_of(projections, columns, rows);
  out.projections = files_of(projections.at("filename"), projections.at("number").whole(1, kMaxViews), layout);
  out.intensities = true;
  out.flats = correction_of(projections, "flat_field", layout);
  out.darks = correction_of(projections, "dark_field", layout);
  if (projections.has("max_intensity")) out.full = projections.at("max_intensity").number();
  if (!output.has("tomogram")) return out;
  const JsonPart tomogram = output.at("tomogram");
  if (!tomogram.has("dimensions") || !tomogram.has("voxelsize")) return out;
  const JsonPart voxels = tomogram.at("dimensions");
  out.geometry.volume.dims = {voxels.at("x").pixels(), voxels.at("y").pixels(), voxels.at("z").pixels()};
  out.geometry.volume.spacing = place(tomogram.at("voxelsize"));
  return out;
}

}  // namespace

ScanDescription read_ctsimu(const std::filesystem::path& file) {
  const JsonPart json = read_json(file);
  const std::string type = json.at("file").at("file_type").text();
  if (type == "CTSimU Scenario") return read_scenario(json);
  if (type == "CTSimU Metadata") return read_metadata(json);
  json.at("file").at("file_type").fault("\"CTSimU Scenario\" or \"CTSimU Metadata\"");
}

}  // namespace gicube::samples

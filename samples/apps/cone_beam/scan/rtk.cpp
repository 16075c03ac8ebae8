// Source of the format: RTK's page "3D Circular Projection Geometry" (openrtk.org).
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>
#include <pugixml.hpp>

#include "cone_beam/scan/formats.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/formats/data_stream.h"

namespace gicube::samples {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::uint64_t kMaxBytes = 64 << 20;  // chosen: a hundred thousand views
constexpr const char* kRoot = "RTKThreeDCircularGeometry";

Vec3 from_rtk(Vec3 v) { return {v.z, v.x, v.y}; }
Vec3 to_rtk(Vec3 v) { return {v.y, v.z, v.x}; }

// Parameters of a view by the names of their elements; those of all views come first.
struct Parameters {
  std::map<std::string, double> values{{"SourceToIsocenterDistance", 0},
                                       {"SourceToDetectorDistance", 0},
                                       {"GantryAngle", 0},
                                       {"ProjectionOffsetX", 0},
                                       {"ProjectionOffsetY", 0},
                                       {"OutOfPlaneAngle", 0},
                                       {"InPlaneAngle", 0},
                                       {"SourceOffsetX", 0},
                                       {"SourceOffsetY", 0},
                                       {"RadiusCylindricalDetector", 0}};

  double at(const char* name) const { return values.at(name); }
  void take(const pugi::xml_node& node, const std::filesystem::path& file, const std::string& where) {
    const auto known = values.find(node.name());
    if (known == values.end()) return;  // collimations and matrices say nothing of where things stand
    const std::string text = node.text().get();
    const std::size_t begin = text.find_first_not_of(" \t\r\n"), end = text.find_last_not_of(" \t\r\n");
    const auto value = parse_number<double>(begin == std::string::npos ? "" : text.substr(begin, end - begin + 1));
    expect(value && std::isfinite(*value), file, where + node.name(), "a number", '"' + text + '"');
    known->second = *value;
  }
};

// Rows of RTK's rotation of the volume: directions of columns, of rows, and towards the source.
struct Axes {
  Vec3 u, v, n;
};
Axes axes_of(double gantry, double out_of_plane, double in_plane) {
  const double ca = std::cos(out_of_plane), sa = -std::sin(out_of_plane);
  const double cb = std::cos(gantry), sb = -std::sin(gantry), cc = std::cos(in_plane), sc = -std::sin(in_plane);
  const Vec3 x{cb, 0, sb}, y{sa * sb, ca, -sa * cb}, z{-ca * sb, sa, ca * cb};
  return {cc * x - sc * y, sc * x + cc * y, z};
}

ViewPose pose_of(const Parameters& given, const Pixels& pixels) {
  const Axes axes = axes_of(kDegree * given.at("GantryAngle"), kDegree * given.at("OutOfPlaneAngle"),
                            kDegree * given.at("InPlaneAngle"));
  const double to_axis = given.at("SourceToIsocenterDistance"), to_detector = given.at("SourceToDetectorDistance");
  // Position of the middle pixel, from the header of the projections.
  const double u = given.at("ProjectionOffsetX") + pixels.first_u + (pixels.columns - 1) / 2.0 * pixels.pitch_u;
  const double v = given.at("ProjectionOffsetY") + pixels.first_v + (pixels.rows - 1) / 2.0 * pixels.pitch_v;
  return {from_rtk(given.at("SourceOffsetX") * axes.u + given.at("SourceOffsetY") * axes.v + to_axis * axes.n),
          from_rtk(u * axes.u + v * axes.v + (to_axis - to_detector) * axes.n), pixels.pitch_u * from_rtk(axes.u),
          pixels.pitch_v * from_rtk(axes.v)};
}

}  // namespace

ScanDescription read_rtk(const std::filesystem::path& file, const StackFiles& projections, const PixelsGiven& given) {
  const auto bytes = file_bytes(file);
  expect(bytes <= kMaxBytes, file, "file", "at most 64 MiB", fmt::format("{} bytes", bytes));
  pugi::xml_document document;
  const auto parsed = document.load_file(file.c_str());
  expect(bool(parsed), file, fmt::format("byte {}", parsed.offset), "XML", parsed.description());
  const pugi::xml_node root = document.document_element();
  expect(std::string(root.name()) == kRoot, file, "root element", kRoot, root.name());
  const Pixels pixels = pixels_of(projections, given, file);
  expect(pixels.pitch_u > 0 && pixels.pitch_v > 0, file, "pitch",
         "projections whose header has a spacing, or the pixels' pitch (--pitch)", "none");
  Parameters shared;
  for (const pugi::xml_node& node : root.children()) shared.take(node, file, "");
  std::vector<ViewPose> views;
  for (const pugi::xml_node& projection : root.children("Projection")) {
    const std::string where = fmt::format("Projection {}, ", views.size() + 1);
    Parameters own = shared;
    for (const pugi::xml_node& node : projection.children()) own.take(node, file, where);
    expect(own.at("SourceToDetectorDistance") != 0, file, where + "SourceToDetectorDistance",
           "a number but 0: parallel beams are not supported", "0");
    expect(own.at("RadiusCylindricalDetector") == 0, file, where + "RadiusCylindricalDetector",
           "0: cylindrical detectors are not supported", fmt::format("{}", own.at("RadiusCylindricalDetector")));
    views.push_back(pose_of(own, pixels));
    check_view(views.back(), file, where + "its parameters");
  }
  expect(views.size() >= 2, file, "Projection", "at least 2", fmt::format("{}", views.size()));
  return scan_of(std::move(views), pixels, file, projections);
}

void write_rtk(const ConeGeometry& geometry, const std::filesystem::path& file) {
  std::string text = fmt::format("<?xml version=\"1.0\"?>\n<!DOCTYPE RTKGEOMETRY>\n<{} version=\"3\">\n", kRoot);
  for (std::size_t view = 0; view < geometry.angles.size(); ++view) {
    const ViewPose at = pose(geometry, view);
    const Vec3 u = (1 / length(at.u)) * to_rtk(at.u), v = (1 / length(at.v)) * to_rtk(at.v), n = cross(u, v);
    expect(std::abs(dot(u, v)) < 1e-6, file, fmt::format("view {}", view), "rows and columns square to each other",
           fmt::format("a cosine of {:.3g}", dot(u, v)));
    const Vec3 source = to_rtk(at.source), middle = to_rtk(at.centre);
    const double sx = dot(u, source), sy = dot(v, source), sz = dot(n, source), d = dot(n, source - middle);
    const double px = dot(u, middle), py = dot(v, middle);
    text += "  <Projection>\n";
    for (const auto& [name, value] : {std::pair{"SourceToIsocenterDistance", sz},
                                      {"SourceToDetectorDistance", d},
                                      {"GantryAngle", std::atan2(n.x, n.z) / kDegree},
                                      {"OutOfPlaneAngle", -std::asin(std::clamp(n.y, -1.0, 1.0)) / kDegree},
                                      {"InPlaneAngle", std::atan2(u.y, v.y) / kDegree},
                                      {"SourceOffsetX", sx},
                                      {"SourceOffsetY", sy},
                                      {"ProjectionOffsetX", px},
                                      {"ProjectionOffsetY", py}}) {
      text += fmt::format("    <{0}>{1:.15g}</{0}>\n", name, value + 0.0);
    }
    const auto row = [&](double along, double shift, Vec3 axis, double source_shift) {
      const Vec3 part = along * axis + shift * n;
      return fmt::format("      {:.15g} {:.15g} {:.15g} {:.15g}\n", part.x, part.y, part.z,
                         -along * source_shift - shift * sz);
    };
    text += "    <Matrix>\n" + row(-d, sx - px, u, sx) + row(-d, sy - py, v, sy) + row(0, 1, n, 0) + "    </Matrix>\n";
    text += "  </Projection>\n";
  }
  write_whole(file, text + fmt::format("</{}>\n", kRoot));
}

}  // namespace gicube::samples

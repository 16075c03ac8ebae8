// Source of the format: CIL's NikonDataReader. The source is at the origin, y runs to the detector, z upwards; the
// object turns about an axis beside y, by AngularStep per view.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "cone_beam/scan/formats.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/formats/readers.h"

namespace gicube::samples {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kMaxViews = 1 << 20, kMaxPixels = 1 << 16;  // chosen

struct Keys {
  std::filesystem::path file;
  std::map<std::string, std::string> values;  // of [XTekCT]

  bool has(const char* key) const { return values.contains(key); }
  double number(const char* key) const {
    const auto found = values.find(key);
    expect(found != values.end(), file, key, "a number", "none");
    const auto value = parse_number<double>(found->second);
    expect(value && std::isfinite(*value), file, key, "a number", '"' + found->second + '"');
    return *value;
  }
  double number_or(const char* key, double otherwise) const { return has(key) ? number(key) : otherwise; }
  double positive(const char* key) const {
    const double value = number(key);
    expect(value > 0, file, key, "a number above 0", fmt::format("{}", value));
    return value;
  }
  int whole(const char* key, int most) const {
    const double value = number(key);
    expect(value >= 1 && value <= most && value == std::floor(value), file, key,
           fmt::format("a whole number from 1 to {}", most), fmt::format("{}", value));
    return static_cast<int>(value);
  }
};

Keys keys_of(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMaxMib = 16;  // chosen
  std::istringstream stream(read_text(file, "a Nikon .xtekct file", kMaxMib));
  Keys out{file, {}};
  std::string line, section;
  while (std::getline(stream, line)) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.starts_with('[')) section = line;
    const std::size_t equals = line.find('=');
    if (section == "[XTekCT]" && equals != std::string::npos) {
      out.values.emplace(line.substr(0, equals), line.substr(equals + 1));
    }
  }
  expect(!out.values.empty(), file, "section", "[XTekCT] with keys", "none");
  return out;
}

std::vector<std::filesystem::path> views_of(const Keys& keys) {
  const auto folder = keys.file.parent_path() / (keys.has("InputFolderName") ? keys.values.at("InputFolderName") : "");
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) return {};
  std::vector<std::filesystem::path> files = files_with(folder, {".tif", ".tiff"});
  const std::string name = keys.has("Name") ? keys.values.at("Name") : "";
  std::erase_if(files, [&](const auto& file) { return !file.filename().string().starts_with(name); });
  return files;
}

}  // namespace

ScanDescription read_nikon(const std::filesystem::path& file) {
  const Keys keys = keys_of(file);
  ScanDescription out;
  out.file = file;
  Detector& detector = out.geometry.detector;
  detector.columns = keys.whole("DetectorPixelsX", kMaxPixels);
  detector.rows = keys.whole("DetectorPixelsY", kMaxPixels);
  const double pitch_u = keys.positive("DetectorPixelSizeX"), pitch_v = keys.positive("DetectorPixelSizeY");
  const double to_axis = keys.positive("SrcToObject"), to_detector = keys.positive("SrcToDetector");
  // CentreOfRotation is the position of the axis on the detector, at its top and bottom.
  const double top = keys.number_or("CentreOfRotationTop", 0), bottom = keys.number_or("CentreOfRotationBottom", 0);
  const double beside = keys.number_or("ObjectOffsetX", (top + bottom) / 2 * to_axis / to_detector);
  const double roll =
      keys.has("ObjectRoll") ? kDegree * keys.number("ObjectRoll") : -std::atan2(top - bottom, detector.rows * pitch_v);
  const double tilt = -kDegree * keys.number_or("ObjectTilt", 0);
  // The axis, and the other axes of the object in the first view.
  const Vec3 z{std::sin(roll), -std::sin(tilt) * std::cos(roll), std::cos(tilt) * std::cos(roll)};
  const Vec3 side = cross(Vec3{0, 1, 0}, z), x = (1 / length(side)) * side, y = cross(z, x);
  const Vec3 middle{-beside, to_axis, 0};
  std::vector<ViewPose> views;
  const int count = keys.whole("Projections", kMaxViews);
  const double first = keys.number_or("InitialAngle", 0) - 180, step = keys.number("AngularStep");
  expect(count >= 2, file, "Projections", "at least 2", fmt::format("{}", count));
  for (int i = 0; i < count; ++i) {
    const double angle = kDegree * (first + i * step), c = std::cos(angle), s = std::sin(angle);
    const auto turned = [&](Vec3 v) {
      const double a = dot(v, x), b = dot(v, y);
      return Vec3{c * a - s * b, s * a + c * b, dot(v, z)};
    };
    // The first column has the greatest x, the first row is the uppermost.
    views.push_back({turned(Vec3{} - middle), turned(Vec3{0, to_detector, 0} - middle), turned({-pitch_u, 0, 0}),
                     turned({0, 0, -pitch_v})});
  }
  set_views(std::move(views), {}, out);
  out.projections.files = views_of(keys);
  out.intensities = true;
  out.full = keys.positive("WhiteLevel");
  if (keys.has("VoxelsX") && keys.has("VoxelsY") && keys.has("VoxelsZ")) {
    out.geometry.volume.dims = {keys.whole("VoxelsX", kMaxPixels), keys.whole("VoxelsY", kMaxPixels),
                                keys.whole("VoxelsZ", kMaxPixels)};
  }
  if (keys.has("VoxelSizeX")) {
    const double edge = keys.positive("VoxelSizeX");
    out.geometry.volume.spacing = {edge, keys.has("VoxelSizeY") ? keys.positive("VoxelSizeY") : edge,
                                   keys.has("VoxelSizeZ") ? keys.positive("VoxelSizeZ") : edge};
  }
  return out;
}

}  // namespace gicube::samples

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "cone_beam/scan/formats.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/formats/readers.h"

namespace gicube::samples {
namespace {

double read_number(std::istream& stream, const std::filesystem::path& file, const char* part, int number) {
  std::string word;
  stream >> word;
  const auto value = signed_number(word);
  expect(value && std::isfinite(*value), file, fmt::format("{} {}", part, number), "a number",
         word.empty() ? "the end" : '"' + word + '"');
  return *value;
}

Vec3 row_of(const ProjectionMatrix& view, std::size_t row) {
  return {view.matrix[4 * row], view.matrix[4 * row + 1], view.matrix[4 * row + 2]};
}

std::string rows_text(const std::vector<std::array<double, 4>>& rows) {
  std::string text;
  for (const auto& row : rows) text += fmt::format("{:20.12e}\n", fmt::join(row, " "));
  return text;
}

std::filesystem::path image_beside(const std::filesystem::path& text) {
  for (const char* extension : {".pfm", ".tif", ".tiff", ".nrrd", ".mha", ".mhd"}) {
    auto image = std::filesystem::path(text).replace_extension(extension);
    std::error_code error;
    if (std::filesystem::is_regular_file(image, error)) return image;
  }
  throw FileError(text, "image", "one beside it: .pfm .tif .tiff .nrrd .mha or .mhd of the same name", "none");
}

}  // namespace

ProjectionMatrix read_projection_matrix(const std::filesystem::path& file) {
  std::ifstream stream(file);
  expect(bool(stream), file, "file", "a text file that can be read", "none");
  ProjectionMatrix view;
  int number = 0;
  for (double& value : view.centre) value = read_number(stream, file, "centre", ++number);
  number = 0;
  for (double& value : view.matrix) value = read_number(stream, file, "matrix", ++number);
  view.source_to_axis = read_number(stream, file, "source to axis", 1);
  view.source_to_detector = read_number(stream, file, "source to detector", 1);
  number = 0;
  for (double* value : {&view.normal.x, &view.normal.y, &view.normal.z}) {
    *value = read_number(stream, file, "normal", ++number);
  }
  std::string word;
  const bool at_end = !(stream >> word);
  expect(at_end || word == "Extrinsic", file, "behind the normal", "\"Extrinsic\" or the end", '"' + word + '"');
  return view;
}

void write_projection_matrix(const ConeGeometry& geometry, double angle, const std::filesystem::path& file) {
  const Detector& detector = geometry.detector;
  const double distance = geometry.source_to_axis, c = std::cos(angle), s = std::sin(angle);
  const double column = (detector.columns - 1) / 2.0 - detector.offset_u / detector.pitch_u;
  const double row = (detector.rows - 1) / 2.0 + detector.offset_v / detector.pitch_v;
  const double u = 1 / detector.pitch_u, v = 1 / detector.pitch_v, w = 1 / geometry.source_to_detector;
  std::string text = fmt::format("{:20.12e} {:20.12e}\n", column, row);
  text += rows_text({{-s * u, c * u, 0, 0}, {0, 0, -v, 0}, {-c * w, -s * w, 0, distance * w}});
  text += fmt::format("{:20.12e}\n{:20.12e}\n{:20.12e} {:20.12e} {:20.12e}\n", distance, geometry.source_to_detector,
                      -c, -s, 0.0);
  text += "Extrinsic\n" + rows_text({{-s, c, 0, 0}, {0, 0, -1, 0}, {-c, -s, 0, distance}, {0, 0, 0, 1}});
  text += "Intrinsic\n" + rows_text({{u, 0, 0, 0}, {0, v, 0, 0}, {0, 0, w, 0}});
  write_whole(file, text);
}

ViewPose pose_of(const ProjectionMatrix& view, int columns, int rows, const std::filesystem::path& file) {
  const Vec3 a = row_of(view, 0), b = row_of(view, 1), c = row_of(view, 2);
  const double volume = dot(a, cross(b, c)), size = length(a) * length(b) * length(c);
  expect(std::abs(volume) > 1e-9 * size, file, "matrix", "three independent rows",
         fmt::format("a determinant of {}", volume));
  expect(view.source_to_detector > 0, file, "source to detector", "a number above 0",
         fmt::format("{}", view.source_to_detector));
  expect(view.source_to_axis > 0, file, "source to axis", "a number above 0", fmt::format("{}", view.source_to_axis));
  // All three rows are 0 at the source.
  ViewPose out;
  out.source =
      (-1 / volume) * (view.matrix[3] * cross(b, c) + view.matrix[7] * cross(c, a) + view.matrix[11] * cross(a, b));
  // A matrix has an arbitrary factor; the scan's middle is in front of the source.
  const double side = view.matrix[11] < 0 ? -1 : 1;
  const double scale = side / (length(c) * view.source_to_detector);
  const Vec3 towards = (side / length(c)) * c;
  // The inverse of the rows' parts in the detector's plane gives the steps between pixels.
  const auto in_plane = [&](Vec3 row) { return scale * (row - (dot(row, c) / dot(c, c)) * c); };
  const Vec3 along_u = in_plane(a), along_v = in_plane(b);
  const double uu = dot(along_u, along_u), vv = dot(along_v, along_v), uv = dot(along_u, along_v);
  const double square = uu * vv - uv * uv;
  out.u = (1 / square) * (vv * along_u - uv * along_v);
  out.v = (1 / square) * (uu * along_v - uv * along_u);
  // Distance in pixels from the foot of the source's perpendicular to the middle.
  const double right = (columns - 1) / 2.0 - view.centre[0] - dot(a, c) / dot(c, c);
  const double down = (rows - 1) / 2.0 - view.centre[1] - dot(b, c) / dot(c, c);
  out.centre = out.source + view.source_to_detector * towards + right * out.u + down * out.v;
  const Vec3 normal = view.normal;
  expect(length(cross(normal, towards)) < 1e-3 * length(normal), file, "normal",
         "along " + in_brackets(towards) + ", as the matrix says", in_brackets(normal));
  check_view(out, file, "matrix");
  return out;
}

ScanDescription read_matrix_folder(const std::filesystem::path& folder, const StackFiles& projections) {
  const std::vector<std::filesystem::path> texts = files_with(folder, {".txt"});
  if (texts.empty()) throw FileError(folder, "folder", "a .txt with a projection matrix for each view", "none");
  ScanDescription out;
  out.file = folder;
  out.projections = projections;
  if (projections.empty()) {
    for (const auto& text : texts) out.projections.files.push_back(image_beside(text));
  }
  // A matrix does not have the number of pixels.
  StackFiles first = out.projections;
  first.files.resize(1);
  const Stack stack = read_stack(first);
  out.geometry.detector.columns = stack.columns;
  out.geometry.detector.rows = stack.rows;
  std::vector<ViewPose> views;
  Vec3 axis;  // as the first view says
  for (const auto& text : texts) {
    const ProjectionMatrix view = read_projection_matrix(text);
    views.push_back(pose_of(view, stack.columns, stack.rows, text));
    const Vec3 normal = cross(views.back().u, views.back().v), towards = (1 / length(normal)) * normal;
    const double side = dot(views.back().centre - views.back().source, towards) < 0 ? -1 : 1;
    if (views.size() == 1) axis = views[0].source + (side * view.source_to_axis) * towards;
  }
  set_views(std::move(views), axis, out);
  return out;
}

}  // namespace gicube::samples

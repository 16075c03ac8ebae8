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
  const auto value = parse_number<double>(std::string_view(word).substr(word.starts_with('+') ? 1 : 0));
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

ViewFrame frame_of(const ProjectionMatrix& view, const std::filesystem::path& file) {
  const Vec3 a = row_of(view, 0), b = row_of(view, 1), c = row_of(view, 2);
  const double volume = dot(a, cross(b, c)), size = length(a) * length(b) * length(c);
  expect(std::abs(volume) > 1e-9 * size, file, "matrix", "three independent rows",
         fmt::format("a determinant of {}", volume));
  expect(view.source_to_detector > 0, file, "source to detector", "a number above 0",
         fmt::format("{}", view.source_to_detector));
  // Where all three rows vanish is the source.
  ViewFrame frame;
  frame.source =
      (-1 / volume) * (view.matrix[3] * cross(b, c) + view.matrix[7] * cross(c, a) + view.matrix[11] * cross(a, b));
  // A matrix counts up to a factor; the scan's middle lies before the source.
  const double scale = (view.matrix[11] < 0 ? -1 : 1) / (length(c) * view.source_to_detector);
  frame.towards = (view.matrix[11] < 0 ? -1 / length(c) : 1 / length(c)) * c;
  frame.distance = view.source_to_detector;
  const auto pixel_step = [&](Vec3 row, double& middle, double centre) {
    const double along = dot(row, c) / dot(c, c);  // pixels between the centre given and the one that the source faces
    middle = centre + along;
    const Vec3 square = scale * (row - along * c);
    return (1 / dot(square, square)) * square;
  };
  frame.along_u = pixel_step(a, frame.middle_column, view.centre[0]);
  frame.along_v = pixel_step(b, frame.middle_row, view.centre[1]);
  const Vec3 normal = view.normal;
  expect(length(cross(normal, frame.towards)) < 1e-3 * length(normal), file, "normal",
         "along " + in_brackets(frame.towards) + ", as the matrix says", in_brackets(normal));
  return frame;
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
  // A matrix doesn't know how many pixels there are.
  StackFiles first = out.projections;
  first.files.resize(1);
  const Stack stack = read_stack(first);
  std::vector<FacingView> views;
  for (const auto& text : texts) {
    const ProjectionMatrix view = read_projection_matrix(text);
    const FrameNames names{text, "matrix, its last row", "matrix, its first row", "matrix, its second row"};
    views.push_back(facing_view(frame_of(view, text), view.source_to_axis, stack.columns, stack.rows, names));
  }
  describe(views, texts, out);
  return out;
}

}  // namespace gicube::samples

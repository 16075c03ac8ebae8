#include "cone_beam/scan/scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "cone_beam/fdk.h"
#include "cone_beam/scan/formats.h"
#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/formats/readers.h"

namespace gicube::samples {
namespace {

// One view between the file's order of pixels and the geometry's; its own inverse.
template <typename Take>
void for_each_pixel(const ScanDescription& description, int of_columns, int of_rows, const Take& take) {
  const auto columns = static_cast<std::size_t>(of_columns), rows = static_cast<std::size_t>(of_rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t to_row = description.rows_reversed ? rows - 1 - row : row;
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t to_column = description.columns_reversed ? columns - 1 - column : column;
      take(row * columns + column, to_row * columns + to_column);
    }
  }
}

void check_size(const ScanDescription& description, const Stack& stack) {
  const std::filesystem::path& file = description.projections.files.front();
  const auto& [to_axis, to_detector, detector, volume, angles] = description.geometry;
  expect(stack.columns == detector.columns && stack.rows == detector.rows, file, "size",
         fmt::format("{} x {} pixels, as the detector has", detector.columns, detector.rows),
         fmt::format("{} x {}", stack.columns, stack.rows));
  expect(stack.views() == angles.size(), file, "views", fmt::format("{}, one an angle", angles.size()),
         std::to_string(stack.views()));
}

// Views of the same angle averaged.
Projections sorted(const Stack& stack, const ScanDescription& description, const SortedViews& order) {
  Projections out{stack.columns, stack.rows, {}};
  const std::size_t size = stack.view_size();
  out.values.resize(size * order.angles.size());
  for (std::size_t view = 0; view < order.angles.size(); ++view) {
    float* const to = out.view(view);
    const auto share = 1 / static_cast<float>(order.places[view].size());
    for (const std::size_t place : order.places[view]) {
      const float* const from = stack.values.data() + place * size;
      for_each_pixel(description, stack.columns, stack.rows,
                     [&](std::size_t stored, std::size_t pixel) { to[pixel] += share * from[stored]; });
    }
  }
  return out;
}

// What the projections can't show.
std::vector<std::string> warnings_of(const Scan& scan, bool intensities) {
  std::vector<std::string> out;
  // Turns of the source, in degrees, that measure every ray at least once.
  const Detector& detector = scan.geometry.detector;
  const double side = std::max(std::abs(u_of(detector, -0.5)), std::abs(u_of(detector, detector.columns - 0.5)));
  const double degrees = 180 / std::numbers::pi, arc = degrees * arc_of(scan.geometry);
  const double wanted = 180 + 2 * degrees * std::atan(side / scan.geometry.source_to_detector);
  if (is_short_scan(scan.geometry) && arc < wanted - 0.01) {
    out.push_back(
        fmt::format("angles: the views stand for {:.1f} degrees, where {:.1f} would measure every ray through the "
                    "detector's field; expect streaks and shadows",
                    arc, wanted));
  }
  // Whether something is seen at the detector's left or right edge: the mean there against the greatest mean of a column.
  std::vector<double> sums(static_cast<std::size_t>(detector.columns));
  for (std::size_t i = 0; i < scan.projections.values.size(); ++i) {
    sums[i % sums.size()] += static_cast<double>(scan.projections.values[i]);
  }
  const double edge = std::max(sums.front(), sums.back()), most = std::ranges::max(sums);
  constexpr double kSeen = 0.05, kBright = 0.95, kLess = 0.9;  // chosen: above noise and flat fields' errors
  if (!intensities && std::min(sums.front(), sums.back()) >= kBright * most && std::ranges::min(sums) < kLess * most) {
    out.push_back(
        "projections: the detector's sides have the greatest values, and columns between them less, as intensities "
        "have; line integrals are expected (intensities need intensities: true in the scan file, with a flat or "
        "full_intensity)");
  } else if (most > 0 && edge >= kSeen * most) {
    out.push_back(
        fmt::format("projections: the object reaches beyond the detector (its edge shows {:.0f}% of the greatest mean "
                    "of a column); values are too high, most of all near the rim of what is seen",
                    100 * edge / most));
  }
  if (scan.flat_field.absorbed > 0) {
    out.push_back(
        fmt::format("projections: {} values without any light left were taken as half a count; "
                    "the object is denser there than can be told",
                    scan.flat_field.absorbed));
  }
  if (scan.flat_field.dead > 0) {
    out.push_back(fmt::format("flat: {} dead pixels have the mean of those beside them", scan.flat_field.dead));
  }
  if (scan.flat_field.unlit > 0) {
    out.push_back(
        fmt::format("projections: {} pixels got no light in any view; they are taken as dead, and have the "
                    "mean of those beside them",
                    scan.flat_field.unlit));
  }
  return out;
}

}  // namespace

ScanDescription read_description(const std::filesystem::path& path, const StackFiles& projections) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return read_matrix_folder(path, projections);
  const bool json = lower_case(path.extension().string()) == ".json";
  ScanDescription out = json ? read_ctsimu(path) : read_scan_file(path);
  if (!projections.empty()) {
    out.projections = projections;
    if (auto& raw = out.projections.raw) raw->dims = {out.geometry.detector.columns, out.geometry.detector.rows, 0};
  }
  return out;
}

std::vector<std::filesystem::path> ScanDescription::inputs() const {
  std::vector<std::filesystem::path> out;
  for (const StackFiles* stack : {&projections, &flats, &darks}) {
    out.insert(out.end(), stack->files.begin(), stack->files.end());
  }
  std::error_code error;
  if (!std::filesystem::is_directory(file, error)) {
    out.push_back(file);
  } else {
    std::ranges::copy(files_with(file, {".txt"}), std::back_inserter(out));
  }
  return out;
}

void complete_volume(ScanDescription& description) {
  Grid& grid = description.geometry.volume;
  const Detector& detector = description.geometry.detector;
  const double at_axis = description.geometry.source_to_axis / description.geometry.source_to_detector;
  const double u = detector.pitch_u * at_axis, v = detector.pitch_v * at_axis;
  if (!(grid.spacing.x > 0)) grid.spacing = {u, u, v};
  if (grid.dims[0] > 0) return;
  const auto voxels = [](double extent, double edge) {
    return std::max(2, static_cast<int>(std::lround(extent / edge)));
  };
  grid.dims = {voxels(detector.columns * u, grid.spacing.x), voxels(detector.columns * u, grid.spacing.y),
               voxels(detector.rows * v, grid.spacing.z)};
}

Scan load_scan(const ScanDescription& description) {
  if (description.projections.empty()) {
    throw InputError(description.file.string(), "projections", "none; name them in the file or by --projections");
  }
  Stack stack = read_stack(description.projections);
  check_size(description, stack);
  Scan out;
  if (description.intensities) {
    out.flat_field =
        correct_flat_field(stack, read_stack(description.flats), read_stack(description.darks), description.full);
  }
  const SortedViews order = sorted_views(description.geometry.angles);
  out.geometry = description.geometry;
  out.geometry.angles = order.angles;
  out.centre = description.centre;
  out.projections = sorted(stack, description, order);
  out.views_read = stack.views();
  out.repeated = order.repeated();
  check(out.geometry);
  out.warnings = warnings_of(out, description.intensities);
  return out;
}

std::vector<float> as_stored(const Projections& projections, const ScanDescription& description) {
  std::vector<float> out(projections.values.size());
  const std::size_t size = projections.view_size();
  for (std::size_t first = 0; first < out.size(); first += size) {
    for_each_pixel(description, projections.columns, projections.rows, [&](std::size_t stored, std::size_t pixel) {
      out[first + stored] = projections.values[first + pixel];
    });
  }
  return out;
}

}  // namespace gicube::samples

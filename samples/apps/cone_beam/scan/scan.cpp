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

// Converts a view between the file's order of pixels and the geometry's; it is its own inverse.
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
  const auto& [to_axis, to_detector, detector, volume, angles, poses] = description.geometry;
  expect(stack.columns == detector.columns && stack.rows == detector.rows, file, "size",
         fmt::format("{} x {} pixels, as the detector has", detector.columns, detector.rows),
         fmt::format("{} x {}", stack.columns, stack.rows));
  expect(stack.views() == angles.size(), file, "views", fmt::format("{}, one an angle", angles.size()),
         std::to_string(stack.views()));
}

// Averages views of the same angle.
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

// Warnings about an object that reaches beyond the detector, except beyond a displaced detector's near side.
void warn_of_sides(const Scan& scan, bool intensities, std::vector<std::string>& out) {
  const Detector& detector = scan.geometry.detector;
  const SidesSeen seen = sides_seen(scan.projections);
  constexpr double kBright = 0.95, kLess = 0.9;  // chosen
  if (!intensities && std::min(seen.first, seen.last) >= kBright && seen.least < kLess) {
    out.push_back(
        "projections: the detector's sides have the greatest values, and columns between them less, like intensities; "
        "line integrals are expected (intensities need intensities: true in the scan file, with a flat or "
        "full_intensity)");
    return;
  }
  const bool first = seen.first >= SidesSeen::kSeen, last = seen.last >= SidesSeen::kSeen;
  if (!scan.geometry.circular() || (!first && !last)) return;
  const double edge = 100 * std::max(seen.first, seen.last), offset = detector.offset_u;
  const std::string shows = fmt::format("(its edge shows {:.0f}% of the greatest mean of a column)", edge);
  if (first && last) {
    out.push_back("projections: the object reaches beyond both sides of the detector " + shows +
                  "; values are too high, most near the rim of the field");
  } else if (std::abs(offset) > 0.01 * detector.columns * detector.pitch_u && (offset > 0) == first) {
    return;  // what a displaced detector is for
  } else {
    out.push_back(
        fmt::format("projections: the object reaches beyond the side of the {} u of the detector alone {}, as a "
                    "displaced detector's with a {} offset_u does, but offset_u is {:g}; values are too high "
                    "near the rim",
                    first ? "least" : "greatest", shows, first ? "positive" : "negative", offset));
  }
}

// Warnings about features that the projections cannot show.
std::vector<std::string> warnings_of(const Scan& scan, bool intensities) {
  std::vector<std::string> out;
  // The least arc, in degrees, that measures every ray.
  const Detector& detector = scan.geometry.detector;
  const double side = std::max(std::abs(u_of(detector, -0.5)), std::abs(u_of(detector, detector.columns - 0.5)));
  const double degrees = 180 / std::numbers::pi;
  const double wanted = 180 + 2 * degrees * std::atan(side / scan.geometry.source_to_detector);
  if (scan.geometry.circular() && is_short_scan(scan.geometry) && degrees * arc_of(scan.geometry) < wanted - 0.01) {
    out.push_back(
        fmt::format("angles: the views cover {:.1f} degrees, but only {:.1f} measure every ray through the "
                    "detector's field; expect streaks and shadows",
                    degrees * arc_of(scan.geometry), wanted));
  }
  warn_of_sides(scan, intensities, out);
  if (scan.flat_field.absorbed > 0) {
    out.push_back(
        fmt::format("projections: {} values without light count as half a count; "
                    "there the object may be denser",
                    scan.flat_field.absorbed));
  }
  if (scan.flat_field.dead > 0) {
    out.push_back(fmt::format("flat: {} dead pixels are interpolated", scan.flat_field.dead));
  }
  if (scan.flat_field.unlit > 0) {
    out.push_back(
        fmt::format("projections: {} pixels have no light in any view; they count as dead, and are "
                    "interpolated",
                    scan.flat_field.unlit));
  }
  if (scan.dead.stuck > 0) {
    out.push_back(
        fmt::format("projections: {} pixels hardly change from view to view, unlike those around them; they "
                    "count as dead, and are interpolated",
                    scan.dead.stuck));
  }
  return out;
}

}  // namespace

ScanDescription read_description(const std::filesystem::path& path, const StackFiles& projections,
                                 const PixelsGiven& given) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return read_matrix_folder(path, projections);
  // A missing file is an error of the scan file.
  const ScanKind kind = std::filesystem::exists(path, error)               ? kind_of(path)
                        : lower_case(path.extension().string()) == ".json" ? ScanKind::kCtsimu
                                                                           : ScanKind::kScanFile;
  ScanDescription out = kind == ScanKind::kCtsimu  ? read_ctsimu(path)
                        : kind == ScanKind::kRtk   ? read_rtk(path, projections, given)
                        : kind == ScanKind::kNikon ? read_nikon(path)
                        : kind == ScanKind::kAstra ? read_astra(path, projections, given)
                                                   : read_scan_file(path);
  if (!projections.empty()) {
    out.projections = projections;
    if (auto& raw = out.projections.raw) raw->dims = {out.geometry.detector.columns, out.geometry.detector.rows, 0};
  }
  return out;
}

std::vector<std::filesystem::path> ScanDescription::inputs() const {
  std::vector<std::filesystem::path> out;
  for (const StackFiles* stack : {&projections, &flats, &darks, &dead}) {
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
  out.dead = repair_pixels(stack, read_stack(description.dead));
  SortedViews order;
  if (description.geometry.circular()) {
    order = sorted_views(description.geometry.angles);
  } else {  // each view is one of its own
    order.angles = description.geometry.angles;
    for (std::size_t view = 0; view < order.angles.size(); ++view) order.places.push_back({view});
  }
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

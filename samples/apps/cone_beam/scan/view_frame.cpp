// A view's source and detector in space, wherever they stand, and what a ConeGeometry makes of them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "cone_beam/scan/formats.h"

namespace gicube::samples {
namespace {

constexpr double kParallel = 1e-4;  // chosen: radians
constexpr double kPixels = 0.05;    // chosen: that views may differ by

}  // namespace

std::string in_brackets(Vec3 v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x, v.y, v.z); }

FacingView facing_view(const ViewFrame& frame, double source_to_axis, int columns, int rows, const FrameNames& names) {
  FacingView out;
  const Vec3 towards = frame.towards;
  const double pitch_u = length(frame.along_u), pitch_v = length(frame.along_v);
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  expect(positive(pitch_u), names.file, names.u, "a direction", in_brackets(frame.along_u));
  expect(positive(pitch_v), names.file, names.v, "a direction", in_brackets(frame.along_v));
  expect(positive(frame.distance), names.file, "source to detector", "a number above 0",
         fmt::format("{}", frame.distance));
  expect(positive(source_to_axis), names.file, "source to axis", "a number above 0", fmt::format("{}", source_to_axis));
  const Vec3 u = (1 / pitch_u) * frame.along_u, v = (1 / pitch_v) * frame.along_v;
  expect(std::abs(towards.z) < kParallel, names.file, names.normal,
         "one square to the axis of rotation, z: tilted detectors are not supported", in_brackets(towards));
  expect(std::abs(dot(u, towards)) < kParallel && std::abs(u.z) < kParallel, names.file, names.u,
         "rows of pixels square to the axis of rotation, z: tilted detectors are not supported", in_brackets(u));
  expect(std::abs(std::abs(v.z) - 1) < kParallel, names.file, names.v,
         "columns of pixels along the axis of rotation, z: tilted detectors are not supported", in_brackets(v));
  out.angle = std::atan2(-towards.y, -towards.x);
  out.source_to_axis = source_to_axis;
  out.source_to_detector = frame.distance;
  out.columns_reversed = dot(u, {towards.y, -towards.x, 0}) < 0;
  out.rows_reversed = v.z < 0;
  const auto offset = [](double middle, int count, double pitch, bool reversed) {
    return ((count - 1) / 2.0 - middle) * pitch * (reversed ? -1 : 1);
  };
  out.detector = {columns,
                  rows,
                  pitch_u,
                  pitch_v,
                  offset(frame.middle_column, columns, pitch_u, out.columns_reversed),
                  offset(frame.middle_row, rows, pitch_v, out.rows_reversed)};
  out.centre = frame.source + source_to_axis * towards;
  const bool known = std::isfinite(out.detector.offset_u + out.detector.offset_v) && std::isfinite(length(out.centre));
  expect(known, names.file, names.normal, "finite places", "numbers too large for them");
  return out;
}

void describe(const std::vector<FacingView>& views, const std::vector<std::filesystem::path>& files,
              ScanDescription& description) {
  const FacingView& first = views.front();
  const double edge = std::max(first.detector.columns, first.detector.rows) / 2.0;
  const double pixel = first.detector.pitch_u;
  // What all views share: the first four as quotients, at the detector's edge, the others as they are.
  constexpr std::array kNames{"source to axis", "source to detector", "pitch of columns",
                              "pitch of rows",  "offset of columns",  "offset of rows",
                              "x of the axis",  "y of the axis",      "z of the source"};
  const auto shared = [](const FacingView& view) {
    const auto& [columns, rows, pitch_u, pitch_v, offset_u, offset_v] = view.detector;
    return std::array{view.source_to_axis, view.source_to_detector, pitch_u,      pitch_v, offset_u, offset_v,
                      view.centre.x,       view.centre.y,           view.centre.z};
  };
  for (std::size_t i = 0; i < views.size(); ++i) {
    const FacingView& view = views[i];
    for (std::size_t k = 0; k < kNames.size(); ++k) {
      const double value = shared(view)[k], other = shared(first)[k];
      const double in_pixels = k < 4 ? (value / other - 1) * edge : (value - other) / pixel;
      expect(std::abs(in_pixels) < kPixels, files[i], kNames[k], fmt::format("{:.9g} as in the first view", other),
             fmt::format("{:.9g}", value));
    }
    expect(view.columns_reversed == first.columns_reversed && view.rows_reversed == first.rows_reversed, files[i],
           "pixels", "columns and rows that run as in the first view", "others");
    description.geometry.angles.push_back(view.angle);
  }
  description.geometry.source_to_axis = first.source_to_axis;
  description.geometry.source_to_detector = first.source_to_detector;
  description.geometry.detector = first.detector;
  description.centre = first.centre;
  description.columns_reversed = first.columns_reversed;
  description.rows_reversed = first.rows_reversed;
}

}  // namespace gicube::samples

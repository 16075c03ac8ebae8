#include "cone_beam/fdk.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/parallel.h"

namespace gicube::samples {
namespace {

void check(const FdkSettings& settings, const ConeGeometry& geometry, const Projections& projections) {
  check(geometry);
  const auto& [window, rays, step, part, normalised, words, read_every, bits, headroom] = settings;
  expect(rays >= 1 && rays <= 4, "rays", "1..4", rays);
  expect(step >= 1.0 / 64 && step <= 16, "step", "1/64..16 voxels", step);
  expect(part >= 0 && part <= 0.25, "sharpen", "0..1/4", part);
  expect(read_every >= 1, "read_every", "at least 1", read_every);
  expect(bits == 0 || (bits >= 4 && bits <= 32), "bits", "0 or 4..32", bits);
  expect(std::isfinite(headroom) && headroom > 0, "headroom", "a finite number above 0", headroom);
  check(projections, geometry);
}

// At fine x fine places a row of `coarse` rows of `columns`, by cubics through four rows; beyond the detector as at its edge.
std::vector<double> finer_rows(const std::vector<double>& coarse, std::size_t columns, int rows, int fine) {
  if (fine == 1) return coarse;
  std::vector<double> out(coarse.size() * static_cast<std::size_t>(fine));
  for (int row = 0; row < rows * fine; ++row) {
    const double at = (row + 0.5) / fine - 0.5;
    const int below = static_cast<int>(std::floor(at));
    const double t = at - below;
    const std::array<double, 4> weights{-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2,
                                        -(t + 1) * t * (t - 2) / 2, (t + 1) * t * (t - 1) / 6};
    double* to = out.data() + static_cast<std::size_t>(row) * columns;
    for (int k = 0; k < 4; ++k) {
      const auto from = static_cast<std::size_t>(std::clamp(below - 1 + k, 0, rows - 1));
      for (std::size_t i = 0; i < columns; ++i)
        to[i] += weights[static_cast<std::size_t>(k)] * coarse[from * columns + i];
    }
  }
  return out;
}

Reconstruction backproject_into_sums(Board& board, const ConeGeometry& geometry, const FdkSettings& settings,
                                     const ViewDensities& filtered, const Progress& progress) {
  const std::size_t views = geometry.angles.size();
  // Filtered twice, since all views together would take more memory than the volume.
  std::vector<double> max_of(views);
  in_parallel(views, 0, [&](std::size_t view) {
    for (const double value : filtered(view)) max_of[view] = std::max(max_of[view], std::abs(value));
  });
  Reconstruction out;
  const auto told_and_filtered = [&](std::size_t view) {
    if (progress) progress(static_cast<std::uint32_t>(view), static_cast<std::uint32_t>(views));
    return filtered(view);
  };
  out.values = backproject(board, geometry, geometry.angles, {settings.rays, settings.step, std::ranges::max(max_of)},
                           told_and_filtered, out);
  return out;
}

}  // namespace

void sharpen(std::vector<float>& values, const Dims& dims, double part) {
  const auto a = static_cast<float>(part);
  std::size_t stride = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto length = static_cast<std::size_t>(dims[axis]), run = stride * length;
    in_parallel(values.size() / run, 0, [&, stride](std::size_t piece) {
      float* const first = values.data() + piece * run;
      for (std::size_t lane = 0; lane < stride; ++lane) {
        float before = first[lane];
        for (std::size_t i = 0; i < length; ++i) {
          float& value = first[lane + i * stride];
          const float here = value, behind = i + 1 < length ? first[lane + (i + 1) * stride] : here;
          value = (1 + 2 * a) * here - a * (before + behind);
          before = here;
        }
      }
    });
    stride = run;
  }
}

RampFilter ramp_filter(const ConeGeometry& geometry, Window window, int fine) {
  const double at_axis = geometry.source_to_axis / geometry.source_to_detector;
  return {geometry.detector.columns, geometry.detector.pitch_u * at_axis, window, fine};
}

std::vector<double> filtered_view(const Projections& projections, const ConeGeometry& geometry, std::size_t view,
                                  const RampFilter& filter, int fine) {
  const Detector& detector = geometry.detector;
  const double distance = geometry.source_to_detector, at_axis = geometry.source_to_axis / distance;
  const double arc = arc_weights(geometry)[view];
  const bool is_short = is_short_scan(geometry);
  const double after = geometry.angles[view] - geometry.angles.front();
  const double whole = geometry.angles.back() - geometry.angles.front();
  const auto columns = static_cast<std::size_t>(detector.columns), wide = columns * static_cast<std::size_t>(fine);
  std::vector<double> rows(wide * static_cast<std::size_t>(detector.rows));
  std::vector<double> row(columns);
  for (int j = 0; j < detector.rows; ++j) {
    const double v = v_of(detector, j);
    const float* from = projections.view(view) + static_cast<std::size_t>(j) * columns;
    for (std::size_t i = 0; i < columns; ++i) {
      const double u = u_of(detector, static_cast<double>(i));
      double weight = slant(distance, u, v);
      if (is_short) weight *= short_scan_weight(after, -std::atan(u / distance), whole);
      row[i] = weight * static_cast<double>(from[i]);
    }
    filter.apply(row.data(), rows.data() + static_cast<std::size_t>(j) * wide);
  }
  std::vector<double> out = finer_rows(rows, wide, detector.rows, fine);
  // Of the value at a place: the arc, the area of a ray at the axis, and the ray's slant, by a voxel's volume.
  const Vec3 edge = geometry.volume.spacing;
  const double area = detector.pitch_u * detector.pitch_v * at_axis * at_axis / (fine * fine);
  const double scale = arc * area / (edge.x * edge.y * edge.z);
  double* value = out.data();
  for_each_ray(detector, fine, [&](double u, double v) {
    *value++ *= scale * distance / std::sqrt(distance * distance + u * u + v * v);
  });
  return out;
}

Reconstruction reconstruct_fdk(Board& board, const ConeGeometry& geometry, const Projections& projections,
                               const FdkSettings& settings, const Progress& progress) {
  check(settings, geometry, projections);
  const Dims dims = geometry.volume.dims;
  const std::vector<std::byte> nothing(voxel_count(dims));
  board.load_volume({.samples = nothing, .dims = dims, .spacing = geometry.volume.spacing});
  const Picoseconds begin = board.now();

  const RampFilter filter = ramp_filter(geometry, settings.window, settings.rays);
  const std::size_t views = geometry.angles.size();
  const ViewDensities filtered = [&](std::size_t view) {
    return filtered_view(projections, geometry, view, filter, settings.rays);
  };
  const bool in_sums = settings.accumulator == Accumulator::kSums;
  Reconstruction out =
      (in_sums ? backproject_into_sums : backproject_into_irradiance)(board, geometry, settings, filtered, progress);
  if (settings.normalise) normalise(out, board, geometry, settings);
  sharpen(out.values, dims, settings.sharpen);
  out.board_time = board.now() - begin;
  if (progress) progress(static_cast<std::uint32_t>(views), static_cast<std::uint32_t>(views));
  return out;
}

}  // namespace gicube::samples

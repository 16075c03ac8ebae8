#include "cone_beam/fdk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cone_beam/facing.h"
#include "gicube/parallel_for.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

// A pixel at the axis: its width along x and y, its height along z.
Vec3 pixel_in_voxels(const ConeGeometry& geometry) {
  const double at_axis = geometry.source_to_axis / geometry.source_to_detector;
  const double u = geometry.detector.pitch_u * at_axis, v = geometry.detector.pitch_v * at_axis;
  const Vec3 edge = geometry.volume.spacing;
  return {u / edge.x, u / edge.y, v / edge.z};
}

void check(const FdkSettings& settings, const ConeGeometry& geometry, const Projections& projections) {
  check(geometry);
  const auto& [window, rays, step, part, normalised, words, read_every, bits, headroom] = settings;
  expect(rays >= 0 && rays <= 4, "rays", "0..4", rays);
  expect(step >= 1.0 / 64 && step <= 16, "step", "1/64..16 voxels", step);
  if (part) expect(*part >= 0 && *part <= 0.25, "sharpen", "0..1/4", *part);
  expect(read_every >= 1, "read_every", "at least 1", read_every);
  expect(bits == 0 || (bits >= 4 && bits <= 32), "bits", "0 or 4..32", bits);
  expect(std::isfinite(headroom) && headroom > 0, "headroom", "a finite number above 0", headroom);
  check(projections, geometry);
}

// Pixels and weights of a ray's value. Pixels beyond the detector repeat its edge.
struct Taps {
  std::array<std::size_t, 4> pixels{};
  std::array<double, 4> weights{};
};
std::vector<Taps> taps_of(std::size_t pixels, int rays) {
  std::vector<Taps> out(pixels * static_cast<std::size_t>(rays));
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double at = (static_cast<double>(i) + 0.5) / rays - 0.5, below = std::floor(at);
    out[i].weights = cubic(at - below);
    for (std::size_t k = 0; k < 4; ++k) {
      const double pixel = below - 1 + static_cast<double>(k);
      out[i].pixels[k] = static_cast<std::size_t>(std::clamp(pixel, 0.0, static_cast<double>(pixels) - 1));
    }
  }
  return out;
}

std::vector<double> finer_view(std::vector<double> pixels, std::size_t columns, PixelRays rays) {
  if (rays == PixelRays{}) return pixels;
  const std::size_t rows = pixels.size() / columns;
  const std::vector<Taps> across = taps_of(columns, rays.u), down = taps_of(rows, rays.v);
  const std::size_t wide = across.size();
  std::vector<double> along(rows * wide), out(down.size() * wide);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t i = 0; i < wide; ++i) {
      for (std::size_t k = 0; k < 4; ++k) {
        along[row * wide + i] += across[i].weights[k] * pixels[row * columns + across[i].pixels[k]];
      }
    }
  }
  for (std::size_t row = 0; row < down.size(); ++row) {
    for (std::size_t k = 0; k < 4; ++k) {
      const double* const from = along.data() + down[row].pixels[k] * wide;
      for (std::size_t i = 0; i < wide; ++i) out[row * wide + i] += down[row].weights[k] * from[i];
    }
  }
  return out;
}

// Scale of a value: the arc times the area of a ray at the axis over a voxel's volume. The caller multiplies it by the
// ray's slant.
double density_scale(const ConeGeometry& geometry, double arc, PixelRays rays) {
  const Vec3 edge = geometry.volume.spacing;
  const double at_axis = geometry.source_to_axis / geometry.source_to_detector;
  const double area = geometry.detector.pitch_u * geometry.detector.pitch_v * at_axis * at_axis / (rays.u * rays.v);
  return arc * area / (edge.x * edge.y * edge.z);
}

// Upper bound of |density| in filtered_view(). It needs no filtered views, which together would take more memory than
// the volume.
double max_density(const Projections& projections, const ConeGeometry& geometry, const RampFilter& filter,
                   PixelRays rays, bool displaced) {
  const auto [least, most] = std::ranges::minmax(projections.values);
  constexpr double kCubics = 1.25 * 1.25;  // overshoot of the cubics of finer_view()
  const double value = std::max(std::abs(double{least}), std::abs(double{most})) * filter.gain();
  return value * density_scale(geometry, std::ranges::max(arc_weights(geometry)), rays) *
         (rays == PixelRays{} ? 1 : kCubics) * (displaced ? 2 : 1);
}

Reconstruction backproject_into_sums(Projector& projector, const ViewDensities& filtered, double max_density,
                                     const Progress& progress) {
  const std::size_t views = projector.setup().views.size();
  Reconstruction out;
  const auto told_and_filtered = [&](std::size_t view) {
    if (progress) progress(static_cast<std::uint32_t>(view), static_cast<std::uint32_t>(views));
    return filtered(view);
  };
  out.values = backproject(projector, max_density, told_and_filtered, out);
  return out;
}

}  // namespace

double voxels_of_a_pixel(const ConeGeometry& geometry) {
  const Vec3 pixel = pixel_in_voxels(geometry);
  return std::max({pixel.x, pixel.y, pixel.z});
}

// chosen: the fewest rays with which hardly any object has more than 1.05 times the error of double precision
// (docs/guide/cone_beam.md). All views share errors along v, so rays must be closer along v than along u.
PixelRays rays_of(const FdkSettings& settings, const ConeGeometry& geometry) {
  if (settings.rays > 0) return {settings.rays, settings.rays};
  constexpr double kOneAcross = 0.9, kOneDown = 0.55, kOneOfSmall = 0.7, kSpacing = 1.25;
  const auto rays = [](double pixel, double one) {
    return pixel <= one ? 1 : static_cast<int>(std::clamp(std::ceil(pixel / kSpacing), 2.0, 4.0));
  };
  const Vec3 pixel = pixel_in_voxels(geometry);
  const double width = std::max(pixel.x, pixel.y);
  return {rays(width, kOneAcross), rays(pixel.z, width <= kOneOfSmall ? kOneOfSmall : kOneDown)};
}

std::array<double, 3> sharpening_of(const FdkSettings& settings, const ConeGeometry& geometry) {
  if (settings.sharpen) return {*settings.sharpen, *settings.sharpen, *settings.sharpen};
  constexpr double kSplat = 1.0 / 12;  // splatting adds a variance of 1/6 voxel^2; a part `a` removes 2 a
  constexpr double kAcross = 0.1;      // chosen: also restores what the cubics lose (measured)
  const PixelRays rays = rays_of(settings, geometry);
  const Vec3 pixel = pixel_in_voxels(geometry);
  const auto across = [&](double width) {
    return rays.u > 1 ? kAcross : std::max(0.0, kSplat * (1 - std::pow(width, 4)));
  };
  return {across(pixel.x), across(pixel.y), rays.v > 1 ? kSplat : std::max(0.0, kSplat * (1 - pixel.z * pixel.z))};
}

void sharpen(std::vector<float>& values, const Dims& dims, const std::array<double, 3>& parts) {
  std::size_t stride = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<float>(parts[axis]);
    const auto length = static_cast<std::size_t>(dims[axis]), run = stride * length;
    if (a == 0) {
      stride = run;
      continue;
    }
    // Processes at most so many adjacent lanes together, in the order of memory [chosen].
    constexpr std::size_t kLanes = 256;
    const std::size_t runs = (stride + kLanes - 1) / kLanes;
    parallel_for(values.size() / run * runs, 0, [&, stride](std::size_t piece) {
      const std::size_t lane = piece % runs * kLanes, lanes = std::min(kLanes, stride - lane);
      float* row = values.data() + piece / runs * run + lane;
      std::array<float, kLanes> before;
      std::copy_n(row, lanes, before.data());
      for (std::size_t i = 0; i < length; ++i, row += stride) {
        const float* const behind = i + 1 < length ? row + stride : row;
        for (std::size_t k = 0; k < lanes; ++k) {
          const float here = row[k];
          row[k] = (1 + 2 * a) * here - a * (before[k] + behind[k]);
          before[k] = here;
        }
      }
    });
    stride = run;
  }
}

RampFilter ramp_filter(const ConeGeometry& geometry, Window window) {
  const double at_axis = geometry.source_to_axis / geometry.source_to_detector;
  return {geometry.detector.columns, geometry.detector.pitch_u * at_axis, window};
}

std::vector<double> filtered_view(const Projections& projections, const ConeGeometry& geometry, std::size_t view,
                                  const RampFilter& filter, PixelRays rays, bool displaced) {
  const ConeGeometry wide = widened(geometry, displaced);
  const Detector& detector = wide.detector;
  const double distance = wide.source_to_detector;
  const WeightedRows rows(geometry, displaced);
  const auto columns = static_cast<std::size_t>(detector.columns);
  std::vector<double> pixels(columns * static_cast<std::size_t>(detector.rows)), slants(pixels.size()), row(columns);
  for (int j = 0; j < detector.rows; ++j) {
    const std::size_t first = static_cast<std::size_t>(j) * columns;
    rows.row(projections, view, j, row.data());
    for (std::size_t i = 0; i < columns; ++i) {
      row[i] *= slants[first + i] = slant(distance, u_of(detector, static_cast<double>(i)), v_of(detector, j));
    }
    filter.apply(row.data(), pixels.data() + first);
  }
  std::vector<double> out = finer_view(std::move(pixels), columns, rays);
  const double scale = density_scale(wide, arc_weights(geometry)[view], rays);
  if (rays == PixelRays{}) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] *= scale * slants[i];
    return out;
  }
  double* value = out.data();
  for_each_ray(detector, rays, [&](double u, double v) { *value++ *= scale * slant(distance, u, v); });
  return out;
}

Reconstruction reconstruct_fdk(Board& board, const ConeGeometry& geometry, const Projections& projections,
                               const FdkSettings& settings, const Progress& progress) {
  if (!geometry.circular()) {
    const FacingViews views = facing(geometry, projections);
    return reconstruct_fdk(board, views.geometry, views.projections, settings, progress);
  }
  check(settings, geometry, projections);
  const PixelRays rays = rays_of(settings, geometry);
  const bool displaced = is_displaced(geometry, projections);
  const ConeGeometry wide = widened(geometry, displaced);
  Projector projector = projector_of(board, wide, settings.step, rays);
  projector.load_nothing();
  const Picoseconds begin = board.now();

  const RampFilter filter = ramp_filter(wide, settings.window);
  const std::size_t views = geometry.angles.size();
  const ViewDensities filtered = [&](std::size_t view) {
    return filtered_view(projections, geometry, view, filter, rays, displaced);
  };
  const bool in_sums = settings.accumulator == Accumulator::kSums;
  Reconstruction out =
      in_sums ? backproject_into_sums(projector, filtered, max_density(projections, geometry, filter, rays, displaced),
                                      progress)
              : backproject_into_irradiance(board, projector, settings, filtered, progress);
  if (settings.normalise) normalise(out, wide, settings);
  sharpen(out.values, geometry.volume.dims, sharpening_of(settings, geometry));
  out.board_time = board.now() - begin;
  if (progress) progress(static_cast<std::uint32_t>(views), static_cast<std::uint32_t>(views));
  return out;
}

}  // namespace gicube::samples

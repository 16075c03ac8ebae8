// Rays that are far apart against voxels leave ripples.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "cone_beam/charts/charts.h"

namespace gicube::samples {
namespace {

// Pixels of this many voxels at the axis.
ConeGeometry spaced(double spacing, int views) {
  ConeGeometry geometry = chart_scan(64, 64, views);
  const double voxel = geometry.volume.spacing.x, pitch = 2 * spacing * voxel;
  geometry.detector = {static_cast<int>(200 / pitch), static_cast<int>(200 / pitch), pitch, pitch};
  geometry.angles.front() = views == 1 ? 0 : geometry.angles.front();
  return geometry;
}

// Rays whose values make a density that rises by `slope` of it along the detector, as projected to the axis.
std::vector<double> densities(const ConeGeometry& geometry, int fine, double slope) {
  const Detector& d = geometry.detector;
  const double near = geometry.source_to_axis / geometry.source_to_detector;
  const Vec3 edge = geometry.volume.spacing;
  std::vector<double> out;
  for_each_ray(d, fine, [&](double u, double v) {
    out.push_back((1 + slope * u) * slant(geometry.source_to_detector, u, v) * d.pitch_u * d.pitch_v * near * near /
                  (fine * fine * edge.x * edge.y * edge.z));
  });
  return out;
}

std::vector<float> splat(Board& board, const ConeGeometry& geometry, int fine, double slope) {
  const std::vector<double> of_rays = densities(geometry, fine, slope);
  Reconstruction ignored;
  return backproject(
      board, geometry, geometry.angles, {fine, 0.5, std::ranges::max(of_rays)}, [&](std::size_t) { return of_rays; },
      ignored);
}

// Root mean square of what was left over what should have been, less 1, in the middle of the volume, where every ray and its
// neighbours pass. `normalised`: left is the quotient of rays that rise and of rays that don't.
std::string ripple(Runner& runner, double spacing, int views, int fine, bool normalised) {
  ConeGeometry geometry = spaced(spacing, views);
  Board board = runner.open("functional", {});
  const std::vector<std::byte> nothing(std::size_t{64} * 64 * 64);
  board.load_volume({.samples = nothing, .dims = geometry.volume.dims, .spacing = geometry.volume.spacing});
  constexpr double kSlope = 0.004;  // chosen: from 0.6 to 1.4 over the detector
  const std::vector<float> sums = splat(board, geometry, fine, normalised ? kSlope : 0);
  const std::vector<float> ones = normalised ? splat(board, geometry, fine, 0) : sums;
  double squares = 0, count = 0;
  for (int z = 16; z < 48; ++z) {
    for (int y = 16; y < 48; ++y) {
      for (int x = 16; x < 48; ++x) {
        const Vec3 at = to_space(geometry.volume, {double(x), double(y), double(z)});
        double wanted = 0, plain = 0;
        for (const double angle : geometry.angles) {
          const double depth = geometry.source_to_axis - (at.x * std::cos(angle) + at.y * std::sin(angle));
          const double u = geometry.source_to_detector / depth * (at.y * std::cos(angle) - at.x * std::sin(angle));
          const double near = geometry.source_to_axis / depth;
          wanted += near * near * (normalised ? 1 + kSlope * u : 1);
          plain += near * near;
        }
        const auto i = static_cast<std::size_t>((z * 64 + y) * 64 + x);
        const double left = static_cast<double>(sums[i]);
        const double even = static_cast<double>(ones[i]);  // 0: no ray comes near, and nothing can be said
        const double part = !normalised ? left / wanted : even == 0 ? 0 : left / even / (wanted / plain);
        squares += (part - 1) * (part - 1);
        ++count;
      }
    }
  }
  const double bare = std::pow(std::sin(std::numbers::pi / spacing) / (std::numbers::pi / spacing), 2);
  return fmt::format("{:g},{:.5g},{:.5g}\n", spacing, std::sqrt(squares / count), bare);
}

}  // namespace

Chart moire_chart() {
  struct Kind {
    const char *name, *title;
    int views, fine;
    bool normalised;
  };
  Chart chart{"moire", "x,ripple,hat_at_the_rays_wave", {}};
  for (const Kind& kind : {Kind{"view", "one view along an axis", 1, 1, false},
                           {"fine", "the same by 2 x 2 rays a pixel", 1, 2, false},
                           {"quotient", "the same divided by splatted weights", 1, 1, true},
                           {"turn", "90 views", 90, 1, false}}) {
    Series series{kind.title, {}};
    for (const double spacing : {0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.7, 2.0, 2.5, 3.0}) {
      series.points.push_back({fmt::format("moire/{}/{:g}", kind.name, spacing), [kind, spacing](Runner& runner) {
                                 return ripple(runner, spacing, kind.views, kind.fine, kind.normalised);
                               }});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart ray_spacing_chart() {
  Chart chart{"ray_spacing", kCaseColumns, {}};
  FdkSettings normalised = kPlainFdk, four = kPlainFdk;
  normalised.normalise = true;
  four.rays = 2;
  for (const auto& [name, title, settings] : {std::tuple{"one", "one ray a pixel", kPlainFdk},
                                              {"normalised", "the same normalised", normalised},
                                              {"four", "2 x 2 rays a pixel", four}}) {
    chart.series.push_back(case_series(title, std::string("ray_spacing/") + name,
                                       {0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 1.7, 2.0, 2.5, 3.0},
                                       [&settings = settings](double spacing) {
                                         return Case{chart_head(), spaced(spacing, 120), settings, {40, 20}};
                                       }));
  }
  return chart;
}

}  // namespace gicube::samples

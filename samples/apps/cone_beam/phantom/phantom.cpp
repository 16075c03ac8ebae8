#include "cone_beam/phantom/phantom.h"

#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <random>

#include "gicube/parallel_for.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

struct Row {
  double kak_slaney, yu_ye_wang;
  Vec3 axes, centre;
  double degrees;
};

constexpr std::array<Row, 10> kHead{{
    {2.00, 1.0, {0.6900, 0.920, 0.900}, {0, 0, 0}, 0},
    {-0.98, -0.8, {0.6624, 0.874, 0.880}, {0, 0, 0}, 0},
    {-0.02, -0.2, {0.4100, 0.160, 0.210}, {-0.22, 0, -0.25}, 108},
    {-0.02, -0.2, {0.3100, 0.110, 0.220}, {0.22, 0, -0.25}, 72},
    {0.02, 0.2, {0.2100, 0.250, 0.500}, {0, 0.35, -0.25}, 0},
    {0.02, 0.2, {0.0460, 0.046, 0.046}, {0, 0.1, -0.25}, 0},
    {0.01, 0.1, {0.0460, 0.023, 0.020}, {-0.08, -0.65, -0.25}, 0},
    {0.01, 0.1, {0.0460, 0.023, 0.020}, {0.06, -0.65, -0.25}, 90},
    {0.02, 0.2, {0.0560, 0.040, 0.100}, {0.06, -0.105, 0.625}, 90},
    {-0.02, -0.2, {0.0560, 0.056, 0.100}, {0, 0.1, 0.625}, 0},
}};

// In the ellipsoid's own axes, where it is the unit sphere; a vector if `place` is a difference.
Vec3 to_unit_sphere(const Ellipsoid& ellipsoid, Vec3 place) {
  const double c = std::cos(ellipsoid.turned), s = std::sin(ellipsoid.turned);
  return {(c * place.x + s * place.y) / ellipsoid.axes.x, (c * place.y - s * place.x) / ellipsoid.axes.y,
          place.z / ellipsoid.axes.z};
}

// Part of the line from `from` to `from + way` inside the ellipsoid.
double part_inside(const Ellipsoid& ellipsoid, Vec3 from, Vec3 way) {
  const Vec3 p = to_unit_sphere(ellipsoid, from - ellipsoid.centre), d = to_unit_sphere(ellipsoid, way);
  const double a = dot(d, d), b = dot(p, d), c = dot(p, p) - 1, square = b * b - a * c;
  return square <= 0 ? 0 : 2 * std::sqrt(square) / a;
}

Phantom head(double radius, double Row::*value) {
  Phantom phantom;
  for (const Row& row : kHead) {
    phantom.push_back({row.*value, radius * row.axes, radius * row.centre, row.degrees * std::numbers::pi / 180});
  }
  return phantom;
}

// The standard defines the values of this engine, but not those of its distributions.
using Engine = std::mt19937_64;

double uniform(Engine& engine) { return (static_cast<double>(engine() >> 11) + 0.5) * 0x1p-53; }  // inside 0..1

// Knuth's product of uniform numbers.
double few(Engine& engine, double mean) {
  const double least = std::exp(-mean);
  double product = uniform(engine), count = 0;
  for (; product > least; ++count) product *= uniform(engine);
  return count;
}

// Hoermann (1993), The transformed rejection method for generating Poisson random variables, algorithm PTRS: for means
// of at least 10.
double many(Engine& engine, double mean) {
  const double b = 0.931 + 2.53 * std::sqrt(mean), a = -0.059 + 0.02483 * b;
  const double inverse_alpha = 1.1239 + 1.1328 / (b - 3.4), quick = 0.9277 - 3.6224 / (b - 2);
  for (;;) {
    const double u = uniform(engine) - 0.5, v = uniform(engine), us = 0.5 - std::abs(u);
    const double k = std::floor((2 * a / us + b) * u + mean + 0.43);
    if (us >= 0.07 && v <= quick) return k;
    if (k < 0 || (us < 0.013 && v > us)) continue;
    const double accepted = k * std::log(mean) - mean - std::lgamma(k + 1);
    if (std::log(v * inverse_alpha / (a / (us * us) + b)) <= accepted) return k;
  }
}

}  // namespace

Phantom shepp_logan(double radius) { return head(radius, &Row::kak_slaney); }
Phantom high_contrast_shepp_logan(double radius) { return head(radius, &Row::yu_ye_wang); }
Phantom uniform_sphere(double radius, double value) { return {{value, {radius, radius, radius}, {}, 0}}; }
Phantom discs(double radius) {
  Phantom out;
  for (int i = -3; i <= 3; ++i) out.push_back({1, {radius, radius, radius / 18}, {0, 0, 11 * radius * i / 36}, 0});
  return out;
}

double value_at(const Phantom& phantom, Vec3 place) {
  double sum = 0;
  for (const Ellipsoid& ellipsoid : phantom) {
    const Vec3 p = to_unit_sphere(ellipsoid, place - ellipsoid.centre);
    if (dot(p, p) <= 1) sum += ellipsoid.value;
  }
  return sum;
}

double line_integral(const Phantom& phantom, Vec3 from, Vec3 to) {
  const Vec3 way = to - from;
  double sum = 0;
  for (const Ellipsoid& ellipsoid : phantom) sum += ellipsoid.value * part_inside(ellipsoid, from, way);
  return sum * length(way);
}

Projections project(const Phantom& phantom, const ConeGeometry& geometry) {
  const Detector& detector = geometry.detector;
  Projections out{detector.columns, detector.rows, {}};
  out.values.resize(out.view_size() * geometry.angles.size());
  parallel_for(geometry.angles.size(), 0, [&](std::size_t view) {
    const ViewPose at = pose(geometry, view);
    float* value = out.view(view);
    for (int row = 0; row < detector.rows; ++row) {
      for (int column = 0; column < detector.columns; ++column) {
        const Vec3 pixel =
            at.centre + (column - (detector.columns - 1) / 2.0) * at.u + (row - (detector.rows - 1) / 2.0) * at.v;
        *value++ = static_cast<float>(line_integral(phantom, at.source, pixel));
      }
    }
  });
  return out;
}

std::vector<float> voxels(const Phantom& phantom, const Grid& grid) {
  const auto slices = static_cast<std::size_t>(grid.dims[2]);
  std::vector<float> out(voxel_count(grid.dims));
  parallel_for(slices, 0, [&](std::size_t z) {
    float* value = out.data() + z * (out.size() / slices);
    for_each_in_slice(grid, z, [&](Vec3 place) { *value++ = static_cast<float>(value_at(phantom, place)); });
  });
  return out;
}

std::size_t add_poisson_noise(Projections& projections, double photons, std::uint64_t seed) {
  expect(std::isfinite(photons) && photons > 0, "photons", "a finite number above 0", photons);
  const std::size_t size = projections.view_size();
  std::atomic<std::size_t> dark{0};
  parallel_for(projections.values.size() / size, 0, [&](std::size_t view) {
    std::seed_seq sequence{seed & 0xFFFFFFFF, seed >> 32, std::uint64_t{view}};
    Engine engine(sequence);
    std::size_t here = 0;
    for (float* value = projections.view(view); value != projections.view(view) + size; ++value) {
      constexpr double kFew = 10;
      const double mean = photons * std::exp(-static_cast<double>(*value));
      const double count = mean < kFew ? few(engine, mean) : many(engine, mean);
      if (count == 0) ++here;
      *value = static_cast<float>(-std::log((count == 0 ? 0.5 : count) / photons));
    }
    dark += here;
  });
  return dark;
}

}  // namespace gicube::samples

#include "fdk_phantoms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "gicube/parallel_for.h"
#include "scene/names.h"

namespace gicube::reference {
namespace {

using samples::ConeGeometry;
using std::numbers::pi;

constexpr auto kEllipsoid = Solid::Shape::kEllipsoid, kBox = Solid::Shape::kBox;
constexpr int kPlaces = 6;  // along a voxel's edge
constexpr double kSourceToAxis = 400, kSourceToDetector = 800;

// In the solid's own axes, where it is the unit ball or the cube of -1..1; a vector if `place` is a difference.
std::array<double, 3> to_unit(const Solid& solid, Vec3 place) {
  const double c = std::cos(solid.turned), s = std::sin(solid.turned);
  return {(c * place.x + s * place.y) / solid.half.x, (c * place.y - s * place.x) / solid.half.y,
          place.z / solid.half.z};
}

bool contains(const Solid& solid, Vec3 place) {
  const auto [x, y, z] = to_unit(solid, place - solid.centre);
  return solid.shape == kBox ? std::max({std::abs(x), std::abs(y), std::abs(z)}) <= 1 : x * x + y * y + z * z <= 1;
}

// The part of the way from `from` to `from + way` that lies in the solid.
double part_inside(const Solid& solid, Vec3 from, Vec3 way) {
  const std::array<double, 3> p = to_unit(solid, from - solid.centre), d = to_unit(solid, way);
  if (solid.shape == kEllipsoid) {
    double dd = 0, pd = 0, pp = 0;
    for (std::size_t i = 0; i < 3; ++i) dd += d[i] * d[i], pd += p[i] * d[i], pp += p[i] * p[i];
    return 2 * std::sqrt(std::max(0.0, pd * pd - dd * (pp - 1))) / dd;
  }
  double first = 0, last = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    if (d[i] == 0) {
      if (std::abs(p[i]) > 1) return 0;
      continue;
    }
    const double one = (-1 - p[i]) / d[i], other = (1 - p[i]) / d[i];
    first = std::max(first, std::min(one, other));
    last = std::min(last, std::max(one, other));
  }
  return std::max(0.0, last - first);
}

// A volume 90 wide; pitches and offsets are told as they are at the axis, in voxels along x.
ConeGeometry geometry_of(int size, Vec3 voxel, double pitch_u, double pitch_v, double offset_u, double offset_v,
                         double first_angle) {
  const double edge = 90.0 / size, magnified = kSourceToDetector / kSourceToAxis;
  ConeGeometry geometry;
  geometry.source_to_axis = kSourceToAxis;
  geometry.source_to_detector = kSourceToDetector;
  geometry.volume = {{size, static_cast<int>(size / voxel.y), static_cast<int>(size / voxel.z)}, edge * voxel};
  geometry.angles = samples::even_angles(2 * size, first_angle, 2 * pi);
  // The volume's corners as the detector sees them, and a pixel more.
  const Vec3 corner = -1.0 * samples::to_space(geometry.volume, {-0.5, -0.5, -0.5});
  const double r = std::hypot(corner.x, corner.y);
  const double half_u = kSourceToDetector * r / std::sqrt(kSourceToAxis * kSourceToAxis - r * r);
  const double half_v = kSourceToDetector * corner.z / (kSourceToAxis - r);
  auto& detector = geometry.detector;
  detector.pitch_u = magnified * edge * pitch_u;
  detector.pitch_v = magnified * edge * pitch_v;
  detector.offset_u = magnified * edge * offset_u;
  detector.offset_v = magnified * edge * offset_v;
  detector.columns = static_cast<int>(2 * (half_u + std::abs(detector.offset_u)) / detector.pitch_u) + 3;
  detector.rows = static_cast<int>(2 * (half_v + std::abs(detector.offset_v)) / detector.pitch_v) + 3;
  return geometry;
}

}  // namespace

std::vector<FdkScan> fdk_scans(int size) {
  return {{"five ellipsoids and a cube",
           geometry_of(size, {1, 1, 1}, 0.9, 1.1, 3.3, -2.1, 0.1),
           {{kEllipsoid, 1.0, {14, 9, 11}, {12, -15, 8}, 0.4},
            {kEllipsoid, 0.7, {8, 16, 7}, {-18, 10, -14}, -0.7},
            {kEllipsoid, 1.3, {6, 6, 12}, {20, 18, -9}, 0},
            {kEllipsoid, 0.5, {18, 7, 5}, {-9, -22, 17}, 1.1},
            {kEllipsoid, -0.4, {5, 4, 5}, {13, -14, 9}, 0},
            {kBox, 0.9, {7, 7, 7}, {-20, -8, -3}, 0.3}}},
          {"boxes in long voxels",
           geometry_of(size, {1, 1, 1.25}, 1.0, 0.75, -2.4, 1.7, 0.6),
           {{kBox, 1.0, {20, 3, 16}, {5, 21, 2}, 0.2},
            {kBox, 0.6, {9, 9, 9}, {-17, -9, -8}, 0.8},
            {kBox, 1.4, {4, 4, 20}, {19, -13, 5}, -0.35},
            {kEllipsoid, 0.8, {11, 8, 6}, {-6, 3, 20}, 0.5}}},
          {"balls, wide pixels",
           geometry_of(size, {1, 1, 1}, 1.2, 1.0, 1.6, 4.2, 1.2),
           {{kEllipsoid, 1.0, {10, 10, 10}, {17, 9, -15}, 0},
            {kEllipsoid, 1.0, {7, 7, 7}, {-21, 14, 13}, 0},
            {kEllipsoid, 1.0, {5, 5, 5}, {4, -24, 6}, 0},
            {kEllipsoid, 1.0, {12, 12, 12}, {-12, -16, -19}, 0},
            {kEllipsoid, 1.0, {3, 3, 3}, {25, -17, 20}, 0},
            {kBox, 1.0, {6, 6, 6}, {5, 22, 19}, 0.5}}},
          {"a shell with cavities, narrow pixels",
           geometry_of(size, {1, 1, 1}, 0.65, 0.8, -4.1, -1.3, 2.0),
           {{kEllipsoid, 1.0, {34, 29, 31}, {3, -2, 1}, 0.3},
            {kEllipsoid, -0.8, {31, 26, 28}, {3, -2, 1}, 0.3},
            {kBox, 0.5, {8, 8, 8}, {-9, 7, 5}, 0.9},
            {kEllipsoid, -0.2, {6, 9, 7}, {15, -10, -6}, -0.4},
            {kEllipsoid, 0.4, {4, 4, 9}, {7, 13, -12}, 0}}}};
}

FdkScan random_fdk_scan(int size, unsigned seed, std::optional<std::array<double, 2>> pixel) {
  std::mt19937 engine(seed);
  const auto between = [&](double low, double high) {  // the same on any machine, unlike the library's distributions
    return low + (high - low) * (static_cast<double>(engine()) + 0.5) * 0x1p-32;
  };
  double pitch_u = std::exp2(between(-1, 1)), pitch_v = std::exp2(between(-1, 1));
  if (pixel) pitch_u = (*pixel)[0], pitch_v = (*pixel)[1];
  const double offset_u = between(-3, 3);
  FdkScan scan{fmt::format("pixels of {:.2f} x {:.2f}", pitch_u, pitch_v),
               geometry_of(size, {1, 1, 1}, pitch_u, pitch_v, offset_u, between(-3, 3), between(0, 6)),
               {}};
  for (int i = 0; i < 6; ++i) {
    Solid solid{i < 5 ? kEllipsoid : kBox, between(0.3, 1.3), {}, {}, between(0, 3)};
    for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      solid.half.*axis = between(3, 16);
      solid.centre.*axis = between(-22, 22);
    }
    scan.object.push_back(solid);
  }
  return scan;
}

samples::Projections project(const FdkScan& scan) {
  const auto& [name, geometry, object] = scan;
  const auto& detector = geometry.detector;
  samples::Projections out{detector.columns, detector.rows, {}};
  out.values.resize(out.view_size() * geometry.angles.size());
  parallel_for(geometry.angles.size(), 0, [&](std::size_t view) {
    const ViewPose at = samples::pose(geometry, view);
    float* value = out.view(view);
    for (int row = 0; row < detector.rows; ++row) {
      for (int column = 0; column < detector.columns; ++column) {
        const double i = column - (detector.columns - 1) / 2.0, j = row - (detector.rows - 1) / 2.0;
        const Vec3 way = at.centre + i * at.u + j * at.v - at.source;
        double sum = 0;
        for (const Solid& solid : object) sum += solid.value * part_inside(solid, at.source, way);
        *value++ = static_cast<float>(sum * length(way));
      }
    }
  });
  return out;
}

std::vector<double> mean_in_voxels(const FdkScan& scan) {
  const samples::Grid& grid = scan.geometry.volume;
  const auto dims = grid.dims;
  const auto slice = static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]);
  std::vector<double> out(samples::voxel_count(dims));
  parallel_for(static_cast<std::size_t>(dims[2]), 0, [&](std::size_t z) {
    double* mean = out.data() + z * slice;
    samples::for_each_in_slice(grid, z, [&](Vec3 middle) {
      double sum = 0;
      for (int i = 0; i < kPlaces * kPlaces * kPlaces; ++i) {
        const auto part = [](int k) { return (k + 0.5) / kPlaces - 0.5; };
        const Vec3 off{part(i % kPlaces) * grid.spacing.x, part(i / kPlaces % kPlaces) * grid.spacing.y,
                       part(i / kPlaces / kPlaces) * grid.spacing.z};
        for (const Solid& solid : scan.object) sum += contains(solid, middle + off) ? solid.value : 0;
      }
      *mean++ = sum / (kPlaces * kPlaces * kPlaces);
    });
  });
  return out;
}

}  // namespace gicube::reference

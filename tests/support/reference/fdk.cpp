#include "fdk.h"

#include <cmath>
#include <numbers>

#include "gicube/parallel_for.h"
#include "scene/names.h"

namespace gicube::reference {
namespace {

using samples::ConeGeometry;
using samples::Projections;
using std::numbers::pi;

// Kak and Slaney (1988), chapter 3, eqs. 61 and 72, times the pitch of the sum.
double ram_lak(int n, double pitch) {
  if (n == 0) return 1 / (4 * pitch);
  return n % 2 == 0 ? 0 : -1 / (pi * pi * n * n * pitch);
}

double kernel_at(Kernel kernel, int n, double pitch) {
  switch (kernel) {
    case Kernel::kRamLak: return ram_lak(n, pitch);
    case Kernel::kSheppLogan: return -2 / (pi * pi * pitch * (4.0 * n * n - 1));
    case Kernel::kHann: return ram_lak(n, pitch) / 2 + (ram_lak(n - 1, pitch) + ram_lak(n + 1, pitch)) / 4;
  }
  return 0;
}

bool is_whole_turn(const ConeGeometry& geometry) {
  const double step = geometry.angles[1] - geometry.angles[0];
  return geometry.angles.back() + step - geometry.angles.front() > 2 * pi - step / 2;
}

// Kak and Slaney, eq. 123 of chapter 3, for columns that run the other way.
double parker(double angle, double column_angle, double arc) {
  const double most = (arc - pi) / 2, fan = -column_angle;
  if (angle <= 2 * (most - fan)) return std::pow(std::sin(pi / 4 * angle / (most - fan)), 2);
  if (angle >= pi - 2 * fan) return std::pow(std::sin(pi / 4 * (pi + 2 * most - angle) / (most + fan)), 2);
  return 1;
}

// Between pixels; nothing beyond the detector.
double between(const std::vector<double>& rows, const samples::Detector& detector, double column, double row) {
  const double i = std::floor(column), j = std::floor(row);
  double sum = 0;
  for (const double dj : {0.0, 1.0}) {
    for (const double di : {0.0, 1.0}) {
      const double x = i + di, y = j + dj;
      if (x < 0 || y < 0 || x >= detector.columns || y >= detector.rows) continue;
      const double weight = (1 - std::abs(column - x)) * (1 - std::abs(row - y));
      sum += weight * rows[static_cast<std::size_t>(x) + static_cast<std::size_t>(y * detector.columns)];
    }
  }
  return sum;
}

}  // namespace

std::vector<double> filter_rows(const ConeGeometry& geometry, const Projections& projections, std::size_t view,
                                Kernel kernel) {
  const auto& detector = geometry.detector;
  const double distance = geometry.source_to_detector;
  const double pitch = detector.pitch_u * geometry.source_to_axis / distance;
  const bool whole = is_whole_turn(geometry);
  const double angle = geometry.angles[view] - geometry.angles.front();
  const double arc = geometry.angles.back() - geometry.angles.front();
  const auto columns = static_cast<std::size_t>(detector.columns);
  std::vector<double> out(projections.view_size()), row(columns), h(columns);
  for (std::size_t n = 0; n < columns; ++n) h[n] = kernel_at(kernel, static_cast<int>(n), pitch);
  for (int j = 0; j < detector.rows; ++j) {
    const double v = samples::v_of(detector, j);
    const std::size_t first = static_cast<std::size_t>(j) * columns;
    for (std::size_t i = 0; i < columns; ++i) {
      const double u = samples::u_of(detector, static_cast<double>(i));
      const double slant = distance / std::sqrt(distance * distance + u * u + v * v);
      const double share = whole ? 0.5 : parker(angle, std::atan(u / distance), arc);
      row[i] = slant * share * static_cast<double>(projections.view(view)[first + i]);
    }
    for (std::size_t i = 0; i < columns; ++i) {
      for (std::size_t k = 0; k < columns; ++k) out[first + i] += row[k] * h[i > k ? i - k : k - i];
    }
  }
  return out;
}

std::vector<double> reconstruct(const ConeGeometry& geometry, const Projections& projections, Kernel kernel) {
  const std::size_t views = geometry.angles.size();
  std::vector<std::vector<double>> filtered(views);
  parallel_for(views, 0, [&](std::size_t i) { filtered[i] = filter_rows(geometry, projections, i, kernel); });

  const auto& grid = geometry.volume;
  const auto& detector = geometry.detector;
  const auto slice = static_cast<std::size_t>(grid.dims[0]) * static_cast<std::size_t>(grid.dims[1]);
  std::vector<double> out(slice * static_cast<std::size_t>(grid.dims[2]));
  const double step = geometry.angles[1] - geometry.angles[0];  // even
  parallel_for(static_cast<std::size_t>(grid.dims[2]), 0, [&](std::size_t z) {
    for (std::size_t i = 0; i < views; ++i) {
      const double c = std::cos(geometry.angles[i]), s = std::sin(geometry.angles[i]);
      for (std::size_t voxel = 0; voxel < slice; ++voxel) {
        const auto width = static_cast<std::size_t>(grid.dims[0]);
        const std::size_t line = voxel / width;
        const auto x = static_cast<double>(voxel % width), y = static_cast<double>(line);
        const Vec3 at = samples::to_space(grid, {x, y, static_cast<double>(z)});
        const double depth = geometry.source_to_axis - (at.x * c + at.y * s);
        const double magnified = geometry.source_to_detector / depth, near = geometry.source_to_axis / depth;
        const double u = magnified * (at.y * c - at.x * s), v = magnified * at.z;
        const double column = (u - detector.offset_u) / detector.pitch_u + (detector.columns - 1) / 2.0;
        const double row = (v - detector.offset_v) / detector.pitch_v + (detector.rows - 1) / 2.0;
        out[z * slice + voxel] += step * near * near * between(filtered[i], detector, column, row);
      }
    }
  });
  return out;
}

}  // namespace gicube::reference

#include <algorithm>
#include <cmath>

#include "cone_beam/fdk.h"
#include "gicube/parallel_for.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

// What rays leave in a unit of volume for Feldkamp's sum to be that of w (R / L)^2 alone, but for w: as filtered_view().
std::vector<double> ones(const ConeGeometry& geometry, int fine) {
  const Detector& detector = geometry.detector;
  const double distance = geometry.source_to_detector, at_axis = geometry.source_to_axis / distance;
  const Vec3 edge = geometry.volume.spacing;
  const double area = detector.pitch_u * detector.pitch_v * at_axis * at_axis / (fine * fine);
  std::vector<double> out;
  for_each_ray(detector, fine,
               [&](double u, double v) { out.push_back(area / (edge.x * edge.y * edge.z) * slant(distance, u, v)); });
  return out;
}

// Whether the hat of a voxel at this place is within the detector's rays in any view.
bool seen_by_all(const ConeGeometry& geometry, Vec3 at) {
  const Detector& d = geometry.detector;
  const Vec3 edge = geometry.volume.spacing;
  const double margin = std::max({edge.x, edge.y, edge.z});
  const double half_u = (d.columns - 1) / 2.0 * d.pitch_u - std::abs(d.offset_u);
  const double half_v = (d.rows - 1) / 2.0 * d.pitch_v - std::abs(d.offset_v);
  const double r = std::hypot(at.x, at.y) + margin, z = std::abs(at.z) + margin, source = geometry.source_to_axis;
  if (r >= source) return false;
  const double distance = geometry.source_to_detector;
  return distance * r / std::sqrt(source * source - r * r) <= half_u && distance * z / (source - r) <= half_v;
}

// Of one slice, since it is the same in all: the sum over views of w (R / L)^2.
std::vector<double> wanted_sums(const ConeGeometry& geometry, const std::vector<double>& arcs) {
  const Grid& grid = geometry.volume;
  const auto columns = static_cast<std::size_t>(grid.dims[0]), rows = static_cast<std::size_t>(grid.dims[1]);
  std::vector<double> out(columns * rows);
  parallel_for(rows, 0, [&](std::size_t y) {
    for (std::size_t view = 0; view < arcs.size(); ++view) {
      const double c = std::cos(geometry.angles[view]), s = std::sin(geometry.angles[view]);
      for (std::size_t x = 0; x < columns; ++x) {
        const Vec3 at = to_space(grid, {static_cast<double>(x), static_cast<double>(y), 0});
        const double near = geometry.source_to_axis / (geometry.source_to_axis - (at.x * c + at.y * s));
        out[y * columns + x] += arcs[view] * near * near;
      }
    }
  });
  return out;
}

}  // namespace

void normalise(Reconstruction& made, Board& board, const ConeGeometry& geometry, const FdkSettings& settings) {
  const std::vector<double> even = ones(geometry, settings.rays), arcs = arc_weights(geometry);
  // chosen: 2000 units per step are enough for sums of hundreds of shares, and of small ones more rays fit a command.
  constexpr double kCoarser = 64;
  const double most = kCoarser * (std::ranges::max(even) * std::ranges::max(arcs));
  const auto densities = [&](std::size_t view) {
    std::vector<double> out = even;
    for (double& value : out) value *= arcs[view];
    return out;
  };
  const std::vector<float> left =
      backproject(board, geometry, geometry.angles, {settings.rays, settings.step, most}, densities, made);
  const std::vector<double> wanted = wanted_sums(geometry, arcs);
  parallel_for(static_cast<std::size_t>(geometry.volume.dims[2]), 0, [&](std::size_t z) {
    std::size_t i = z * wanted.size();
    for_each_in_slice(geometry.volume, z, [&](Vec3 place) {
      const bool whole = left[i] > 0 && seen_by_all(geometry, place);
      if (whole) made.values[i] *= static_cast<float>(wanted[i - z * wanted.size()] / static_cast<double>(left[i]));
      ++i;
    });
  });
}

}  // namespace gicube::samples

#include "cone_beam/normalise.h"

#include <algorithm>
#include <cmath>

#include "cone_beam/backprojector.h"
#include "cone_beam/parallel_for.h"

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
class SeenByAll {
 public:
  explicit SeenByAll(const ConeGeometry& geometry)
      : source_(geometry.source_to_axis), distance_(geometry.source_to_detector) {
    const Detector& d = geometry.detector;
    const Vec3 edge = geometry.volume.spacing;
    margin_ = std::max({edge.x, edge.y, edge.z});
    half_u_ = (d.columns - 1) / 2.0 * d.pitch_u - std::abs(d.offset_u);
    half_v_ = (d.rows - 1) / 2.0 * d.pitch_v - std::abs(d.offset_v);
  }
  bool operator()(Vec3 at) const {
    const double r = std::hypot(at.x, at.y) + margin_, z = std::abs(at.z) + margin_;
    if (r >= source_) return false;
    return distance_ * r / std::sqrt(source_ * source_ - r * r) <= half_u_ && distance_ * z / (source_ - r) <= half_v_;
  }

 private:
  double source_, distance_, margin_ = 0, half_u_ = 0, half_v_ = 0;
};

// Of one slice, since it is the same in all: the sum over views of w (R / L)^2.
std::vector<double> wanted_sums(const ConeGeometry& geometry, const std::vector<double>& arcs) {
  const Grid& grid = geometry.volume;
  std::vector<double> out(static_cast<std::size_t>(grid.dims[0]) * static_cast<std::size_t>(grid.dims[1]));
  parallel_for(static_cast<std::size_t>(grid.dims[1]), [&](std::size_t y) {
    for (std::size_t view = 0; view < arcs.size(); ++view) {
      const double c = std::cos(geometry.angles[view]), s = std::sin(geometry.angles[view]);
      for (int x = 0; x < grid.dims[0]; ++x) {
        const Vec3 at = to_space(grid, {static_cast<double>(x), static_cast<double>(y), 0});
        const double near = geometry.source_to_axis / (geometry.source_to_axis - (at.x * c + at.y * s));
        out[y * static_cast<std::size_t>(grid.dims[0]) + static_cast<std::size_t>(x)] += arcs[view] * near * near;
      }
    }
  });
  return out;
}

}  // namespace

void normalise(Reconstruction& made, Board& board, const ConeGeometry& geometry, const FdkSettings& settings) {
  const std::vector<double> even = ones(geometry, settings.rays), arcs = arc_weights(geometry);
  const double most = *std::max_element(even.begin(), even.end()) * *std::max_element(arcs.begin(), arcs.end());
  // chosen: 2000 units a step are enough for sums of hundreds of shares, and of small ones more rays fit a command.
  constexpr double kCoarser = 64;
  Backprojector backprojector(board, geometry, settings.rays, settings.step, kCoarser * most, arcs.size());
  std::vector<double> densities(even.size());
  for (std::size_t view = 0; view < arcs.size(); ++view) {
    std::transform(even.begin(), even.end(), densities.begin(), [&](double value) { return arcs[view] * value; });
    backprojector.add(geometry.angles[view], densities);
  }
  const std::vector<float> left = backprojector.finish();
  const std::vector<double> wanted = wanted_sums(geometry, arcs);
  const SeenByAll seen(geometry);
  parallel_for(static_cast<std::size_t>(geometry.volume.dims[2]), [&](std::size_t z) {
    std::size_t i = z * wanted.size();
    for_each_in_slice(geometry.volume.dims, [&](int x, int y) {
      const bool whole = left[i] > 0 && seen(to_space(geometry.volume, {double(x), double(y), double(z)}));
      if (whole) made.values[i] *= static_cast<float>(wanted[i - z * wanted.size()] / static_cast<double>(left[i]));
      ++i;
    });
  });
  made.rays += backprojector.rays();
  made.deposits += backprojector.deposits();
  made.overflowed += backprojector.overflowed();
}

}  // namespace gicube::samples

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "cone_beam/fdk.h"
#include "gicube/parallel_for.h"

namespace gicube::samples {
namespace {

constexpr double kPlaces = 4;  // chosen: of depths and radii in a voxel's edge

// Density that the rows of a view's rays deposit in voxels at a depth, relative to uniform rays;
// docs/guide/cone_beam.md derives it.
class RowRipples {
 public:
  RowRipples(const ConeGeometry& geometry, int fine) : geometry_(geometry) {
    for (const double angle : geometry.angles) towards_source_.push_back({std::cos(angle), std::sin(angle), 0});
    const Vec3 edge = geometry.volume.spacing, corner = to_space(geometry.volume, {0, 0, 0});
    step_ = std::min(edge.x, edge.y) / kPlaces;
    reach_ = std::hypot(corner.x, corner.y) + 2 * step_;
    depths_ = static_cast<std::size_t>(2 * reach_ / step_) + 2;
    ripples_.resize(depths_ * heights());
    // Rays within a voxel's hat have several depths: three depths give the same mean and variance.
    const double off = std::sqrt((edge.x * edge.x + edge.y * edge.y) / 4);
    parallel_for(depths_, 0, [&](std::size_t i) {
      const double depth = geometry.source_to_axis - reach_ + static_cast<double>(i) * step_;
      for (const auto& [from, part] : {std::pair{0.0, 2.0 / 3}, {off, 1.0 / 6}, {-off, 1.0 / 6}}) {
        add_rows(depth + from, fine, part, ripples_.data() + i * heights());
      }
    });
  }

  // Ideal density over actual density, for all heights at (x, y, 0).
  std::vector<float> factors(double x, double y, const std::vector<double>& arcs) const {
    std::vector<double> weights(depths_);
    double wanted = 0;
    for (std::size_t view = 0; view < arcs.size(); ++view) {
      const double nearer = x * towards_source_[view].x + y * towards_source_[view].y;
      const double near = geometry_.source_to_axis / (geometry_.source_to_axis - nearer);
      const double weight = arcs[view] * near * near, place = (reach_ - nearer) / step_;
      const auto i = static_cast<std::size_t>(place);
      const double beyond = place - static_cast<double>(i);
      weights[i] += weight * (1 - beyond);
      weights[i + 1] += weight * beyond;
      wanted += weight;
    }
    std::vector<float> left(heights());
    for (std::size_t i = 0; i < depths_; ++i) {
      if (weights[i] == 0) continue;
      const auto weight = static_cast<float>(weights[i] / wanted);
      const float* const ripples = ripples_.data() + i * heights();
      for (std::size_t z = 0; z < left.size(); ++z) left[z] += weight * ripples[z];
    }
    for (float& value : left) value = value > 0 ? 1 / value : 1;
    return left;
  }

 private:
  std::size_t heights() const { return static_cast<std::size_t>(geometry_.volume.dims[2]); }

  // Adds `part` of the hats of the rows of rays at this depth, times the distance between rows. A voxel on a face has
  // rays only on one side, and twice their sum.
  void add_rows(double depth, int fine, double part, float* out) const {
    const Detector& detector = geometry_.detector;
    const double scale = depth / geometry_.source_to_detector;
    const double between = detector.pitch_v / fine * scale / geometry_.volume.spacing.z;
    for (int row = 0; row < detector.rows * fine; ++row) {
      const double v = v_of(detector, (row + 0.5) / fine - 0.5) * scale;
      const double z = to_voxels(geometry_.volume, {0, 0, v}).z, last = static_cast<double>(heights() - 1);
      if (z < 0 || z > last) continue;
      const auto below = std::min(static_cast<std::size_t>(z), heights() - 2);
      for (const std::size_t voxel : {below, below + 1}) {
        const double sides = voxel == 0 || voxel == heights() - 1 ? 2 : 1;
        out[voxel] += static_cast<float>(part * between * sides * (1 - std::abs(z - static_cast<double>(voxel))));
      }
    }
  }

  const ConeGeometry& geometry_;
  std::vector<Vec3> towards_source_;  // of each view, from the axis
  double step_ = 0, reach_ = 0;       // between depths; from the axis to the farthest
  std::size_t depths_ = 0;
  std::vector<float> ripples_;  // of the heights at each depth
};

// Greatest height at which the hat of a voxel at this distance from the axis is inside the detector's rays in every
// view; negative: none.
double height_seen_by_all(const ConeGeometry& geometry, double radius) {
  const Detector& d = geometry.detector;
  const Vec3 edge = geometry.volume.spacing;
  const double margin = std::max({edge.x, edge.y, edge.z});
  const double half_u = (d.columns - 1) / 2.0 * d.pitch_u - std::abs(d.offset_u);
  const double half_v = (d.rows - 1) / 2.0 * d.pitch_v - std::abs(d.offset_v);
  const double r = radius + margin, source = geometry.source_to_axis, distance = geometry.source_to_detector;
  if (r >= source || distance * r / std::sqrt(source * source - r * r) > half_u) return -1;
  return half_v * (source - r) / distance - margin;
}

bool is_even_turn(const ConeGeometry& geometry, const std::vector<double>& arcs) {
  constexpr double kEven = 1e-3;  // chosen: of an arc, so small a change of which changes no ripple
  const auto [least, most] = std::ranges::minmax(arcs);
  return !is_short_scan(geometry) && most - least <= kEven * most;
}

}  // namespace

void normalise(Reconstruction& made, const ConeGeometry& geometry, const FdkSettings& settings) {
  const std::vector<double> arcs = arc_weights(geometry);
  const Grid& grid = geometry.volume;
  const RowRipples ripples(geometry, rays_of(settings, geometry).v);
  const Vec3 corner = to_space(grid, {0, 0, 0});
  const auto columns = static_cast<std::size_t>(grid.dims[0]), rows = static_cast<std::size_t>(grid.dims[1]);
  const auto heights = static_cast<std::size_t>(grid.dims[2]);
  // In a uniform whole turn all places at one distance from the axis have the same factors.
  const double step = std::min(grid.spacing.x, grid.spacing.y) / kPlaces;
  std::vector<std::vector<float>> by_radius(
      is_even_turn(geometry, arcs) ? static_cast<std::size_t>(std::hypot(corner.x, corner.y) / step) + 2 : 0);
  parallel_for(by_radius.size(), 0,
               [&](std::size_t i) { by_radius[i] = ripples.factors(static_cast<double>(i) * step, 0, arcs); });
  parallel_for(rows, 0, [&](std::size_t y) {
    for (std::size_t x = 0; x < columns; ++x) {
      const Vec3 at = to_space(grid, {static_cast<double>(x), static_cast<double>(y), 0});
      const double radius = std::hypot(at.x, at.y), seen = height_seen_by_all(geometry, radius);
      const auto nearest = static_cast<std::size_t>(std::lround(radius / step));
      const std::vector<float> own = by_radius.empty() ? ripples.factors(at.x, at.y, arcs) : std::vector<float>();
      const std::vector<float>& factors = by_radius.empty() ? own : by_radius[nearest];
      for (std::size_t z = 0; z < heights; ++z) {
        const double height = std::abs(corner.z + static_cast<double>(z) * grid.spacing.z);
        if (height <= seen) made.values[(z * rows + y) * columns + x] *= factors[z];
      }
    }
  });
}

}  // namespace gicube::samples

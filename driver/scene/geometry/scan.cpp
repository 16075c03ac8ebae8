#include "gicube/scene/voxeliser.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "scene/common/cells.h"

namespace gicube::scene {
namespace {

// Densities, 0..1, x fastest.
struct Grid {
  Dims dims{};
  std::vector<float> values;

  float at(int x, int y, int z) const { return values[index_of(dims, {x, y, z})]; }

  // -1 outside of the box from the first to the last voxel's centre.
  double interpolate(Vec3 p) const {
    const auto inside = [](double v, int dim) { return v >= 0 && v <= dim - 1; };
    if (!inside(p.x, dims[0]) || !inside(p.y, dims[1]) || !inside(p.z, dims[2])) return -1;
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y), z = static_cast<int>(p.z);
    const int right = std::min(x + 1, dims[0] - 1), up = std::min(y + 1, dims[1] - 1),
              top = std::min(z + 1, dims[2] - 1);
    const double u = p.x - x, v = p.y - y, w = p.z - z;
    const auto row = [&](int j, int k) { return std::lerp(double(at(x, j, k)), double(at(right, j, k)), u); };
    return std::lerp(std::lerp(row(y, z), row(up, z), v), std::lerp(row(y, top), row(up, top), v), w);
  }
};

// The means of cubes with edges of `factor` voxels; remaining voxels at the far faces are omitted.
Grid averaged(const Volume& scan, const ValueRange& range, int factor) {
  const std::vector<float> values = values_of(scan);
  Grid grid;
  for (std::size_t axis = 0; axis < 3; ++axis) grid.dims[axis] = std::max(scan.dims[axis] / factor, 1);
  each_voxel(grid.dims, [&](const Dims& at, std::size_t) {
    double sum = 0;
    int count = 0;
    const auto end = [&](std::size_t axis) { return std::min((at[axis] + 1) * factor, scan.dims[axis]); };
    for (int k = at[2] * factor; k < end(2); ++k) {
      for (int j = at[1] * factor; j < end(1); ++j) {
        for (int i = at[0] * factor; i < end(0); ++i, ++count) {
          const double value = (values[index_of(scan.dims, {i, j, k})] - range.low) / (range.high - range.low);
          sum += std::isnan(value) ? 0 : std::clamp(value, 0.0, 1.0);
        }
      }
    }
    grid.values.push_back(static_cast<float>(sum / count));
  });
  return grid;
}

}  // namespace

Affine scan_space(const Volume& scan) {
  const Vec3 edge{scan.spacing.x * scan.dims[0], scan.spacing.y * scan.dims[1], scan.spacing.z * scan.dims[2]};
  const double scale = 1 / std::max({edge.x, edge.y, edge.z});
  const Vec3 middle{0.5 * (scan.dims[0] - 1), 0.5 * (scan.dims[1] - 1), 0.5 * (scan.dims[2] - 1)};
  return compose(scaling(scale * scan.spacing), translation(-1 * middle));
}

PlacedScan place_scan(const Volume& scan, const ValueRange& range, const Affine& to_voxels) {
  const Affine from_scan = compose(to_voxels, scan_space(scan));
  // World voxels per scan voxel along an edge: below one half, a world voxel covers several of the scan.
  const double size = std::cbrt(std::abs(determinant(from_scan)));
  const int factor = std::max(static_cast<int>(std::floor(1 / size)), 1);
  const auto grid = std::make_shared<const Grid>(averaged(scan, range, factor));
  const double shift = 0.5 * (factor - 1);  // a cube's middle, in scan voxels from its first
  const Affine to_grid = compose(
      compose(scaling((1.0 / factor) * Vec3{1, 1, 1}), translation({-shift, -shift, -shift})), inverse(from_scan));
  PlacedScan placed;
  placed.density = [grid, to_grid](Vec3 p) { return grid->interpolate(to_grid.point(p)); };
  placed.low = {1e300, 1e300, 1e300};
  placed.high = -1 * placed.low;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p =
        from_scan.point({(corner & 1) != 0 ? scan.dims[0] - 1.0 : 0, (corner & 2) != 0 ? scan.dims[1] - 1.0 : 0,
                         (corner & 4) != 0 ? scan.dims[2] - 1.0 : 0});
    placed.low = {std::min(placed.low.x, p.x), std::min(placed.low.y, p.y), std::min(placed.low.z, p.z)};
    placed.high = {std::max(placed.high.x, p.x), std::max(placed.high.y, p.y), std::max(placed.high.z, p.z)};
  }
  return placed;
}

PlacedScan place_density(const Dims& dims, const ScanField& density, int threads) {
  const auto grid = std::make_shared<Grid>(Grid{dims, std::vector<float>(voxels_of(dims))});
  each_cell(dims, threads, [&](const Dims& first) {
    each_voxel(dims, first, [&](Vec3 p, std::size_t index) { grid->values[index] = static_cast<float>(density(p)); });
  });
  PlacedScan placed;
  placed.density = [grid](Vec3 p) { return grid->interpolate(p); };
  placed.high = {dims[0] - 1.0, dims[1] - 1.0, dims[2] - 1.0};
  return placed;
}

}  // namespace gicube::scene

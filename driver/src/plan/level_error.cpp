// The difference of a coarser volume from its original.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "encode/opacity_change.h"
#include "encode/volume/samples.h"
#include "gicube/level_of_detail.h"
#include "gicube/wire/voxel.h"

namespace gicube {
namespace {

// The two voxels around a coordinate.
struct Between {
  std::size_t from, to;
  float weight;  // of `to`
};

Between between(double at, int size) {
  const double inside = std::clamp(at, 0.0, size - 1.0);
  const int from = std::min(static_cast<int>(inside), size - 2);
  return {static_cast<std::size_t>(from), static_cast<std::size_t>(from) + 1, static_cast<float>(inside - from)};
}

// A coordinate in both volumes.
struct Place {
  Between fine, coarse;
};

// All coordinates on one axis at which either volume's interpolation can change its slope. Between neighbouring ones
// both are trilinear, so their difference has its extremes at these coordinates.
std::vector<Place> turning_places(int fine, int coarse, double low, double edge) {
  std::vector<double> places;
  for (int i = 0; i < fine; ++i) places.push_back(i);
  for (int i = 0; i < coarse; ++i) {
    const double at = low + edge * i;
    if (at < fine - 1 && at != std::floor(at)) places.push_back(at);
  }
  std::sort(places.begin(), places.end());
  std::vector<Place> out;
  for (const double at : places) out.push_back({between(at, fine), between((at - low) / edge, coarse)});
  return out;
}

struct Grid {
  Dims dims{};
  std::vector<float> densities;

  const float* row(std::size_t y, std::size_t z) const {
    return densities.data() + (z * static_cast<std::size_t>(dims[1]) + y) * static_cast<std::size_t>(dims[0]);
  }
  // Interpolates the row at (y, z).
  void blend(const Between& y, const Between& z, std::vector<float>& out) const {
    const float *a = row(y.from, z.from), *b = row(y.to, z.from), *c = row(y.from, z.to), *d = row(y.to, z.to);
    const float wa = (1 - y.weight) * (1 - z.weight), wb = y.weight * (1 - z.weight), wc = (1 - y.weight) * z.weight,
                wd = y.weight * z.weight;
    for (std::size_t x = 0; x < out.size(); ++x) out[x] = wa * a[x] + wb * b[x] + wc * c[x] + wd * d[x];
  }
};

Grid densities_of(const VolumeView& view, ValueRange range) {
  Grid grid{view.dims, std::vector<float>(voxel_count(view.dims))};
  const double scale = wire::kDensityMax / (range.high - range.low);
  with_samples(view, [&](auto source) {
    for (std::size_t i = 0; i < grid.densities.size(); ++i) {
      const double density = (static_cast<double>(source[i]) - range.low) * scale;
      grid.densities[i] = static_cast<float>(std::clamp(density, 0.0, double{wire::kDensityMax}));
    }
  });
  return grid;
}

float along(const std::vector<float>& row, const Between& x) {
  return row[x.from] + x.weight * (row[x.to] - row[x.from]);
}

struct Differences {
  double largest = 0, squares = 0;
  std::size_t points = 0;
};

Differences differences(const Grid& fine, const Grid& coarse, const Placement& placement) {
  const double low[] = {placement.low.x, placement.low.y, placement.low.z};
  std::array<std::vector<Place>, 3> places;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    places[axis] = turning_places(fine.dims[axis], coarse.dims[axis], low[axis], placement.edge);
  }
  std::vector<float> fine_row(static_cast<std::size_t>(fine.dims[0])),
      coarse_row(static_cast<std::size_t>(coarse.dims[0]));
  Differences out;
  for (const Place& z : places[2]) {
    for (const Place& y : places[1]) {
      fine.blend(y.fine, z.fine, fine_row);
      coarse.blend(y.coarse, z.coarse, coarse_row);
      float largest = 0;
      double squares = 0;
      for (const Place& x : places[0]) {
        const float difference = std::abs(along(fine_row, x.fine) - along(coarse_row, x.coarse));
        largest = std::max(largest, difference);
        squares += static_cast<double>(difference) * static_cast<double>(difference);
      }
      out.largest = std::max(out.largest, static_cast<double>(largest));
      out.squares += squares;
      out.points += places[0].size();
    }
  }
  return out;
}

}  // namespace

LevelError level_error(const VolumeView& volume, const DerivedVolume& coarse,
                       std::span<const TransferFunction> functions) {
  const ValueRange range = coarse.range;
  const Grid fine = densities_of(volume, range);
  const Differences found = differences(fine, densities_of(coarse.view(), range), coarse.placement);
  LevelError error;
  error.largest_density = std::min(found.largest + 1, double{wire::kDensityMax});  // both are rounded to whole units
  error.rms_density = std::sqrt(found.squares / static_cast<double>(found.points));
  if (functions.empty()) return error;
  const auto [low, high] = std::minmax_element(fine.densities.begin(), fine.densities.end());
  error.largest_opacity =
      largest_opacity_change(functions, range, static_cast<int>(std::floor(*low)), static_cast<int>(std::ceil(*high)),
                             static_cast<int>(std::ceil(error.largest_density)));
  return error;
}

}  // namespace gicube

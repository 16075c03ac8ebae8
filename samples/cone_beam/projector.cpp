#include "cone_beam/projector.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "cone_beam/view_rays.h"

namespace gicube::samples {

void load_values(Board& board, const Grid& grid, std::span<const float> values) {
  const std::size_t voxels = voxel_count(grid.dims);
  if (values.size() != voxels) {
    throw BadArgument("volume", std::to_string(voxels) + " values", std::to_string(values.size()));
  }
  float low = 0, high = 0;
  for (const float value : values) {
    if (!std::isfinite(value)) throw BadArgument("volume", "finite values", std::to_string(value));
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (low == high) high = low + 1;                    // nothing anywhere
  const std::vector<float> no_gradients(3 * voxels);  // finding them would take longer than all else here
  board.load_volume({.samples = std::as_bytes(values),
                     .type = SampleType::kFloat32,
                     .dims = grid.dims,
                     .spacing = grid.spacing,
                     .range = ValueRange{low, high},
                     .gradients = no_gradients});
}

void Projector::begin(double angle) {
  View view;
  std::vector<HostRay> all = view_rays(geometry_, angle);
  for (std::size_t pixel = 0; pixel < all.size(); ++pixel) {
    if (all[pixel].length <= 0) continue;
    view.rays.push_back(all[pixel]);
    view.pixels.push_back(pixel);
  }
  rays_ += view.rays.size();
  view.ticket = board_.submit(view.rays, {.type = RayType::kIntegral, .step = step_});
  under_way_.push_back(std::move(view));
}

std::vector<float> Projector::next() {
  const View view = std::move(under_way_.front());
  under_way_.erase(under_way_.begin());
  std::vector<TracedRay> traced(view.rays.size());
  board_.receive(view.ticket, traced);
  const double low = board_.value_range().low;
  std::vector<float> out(static_cast<std::size_t>(geometry_.detector.columns) *
                         static_cast<std::size_t>(geometry_.detector.rows));
  for (std::size_t i = 0; i < traced.size(); ++i) {
    const double below = low == 0 ? 0 : low * length_in_space(geometry_.volume, view.rays[i]);
    out[view.pixels[i]] = static_cast<float>(traced[i].integral + below);
  }
  return out;
}

Projections project_by_board(Board& board, const ConeGeometry& geometry, std::span<const float> volume, double step,
                             const Progress& progress) {
  check(geometry);
  load_values(board, geometry.volume, volume);
  Projections out{geometry.detector.columns, geometry.detector.rows, {}};
  const std::size_t views = geometry.angles.size();
  out.values.reserve(views * out.view_size());
  Projector projector(board, geometry, step);
  projector.begin(geometry.angles[0]);
  for (std::size_t view = 0; view < views; ++view) {
    if (progress) progress(static_cast<std::uint32_t>(view), static_cast<std::uint32_t>(views));
    if (view + 1 < views) projector.begin(geometry.angles[view + 1]);
    const std::vector<float> values = projector.next();
    out.values.insert(out.values.end(), values.begin(), values.end());
  }
  if (progress) progress(static_cast<std::uint32_t>(views), static_cast<std::uint32_t>(views));
  return out;
}

}  // namespace gicube::samples

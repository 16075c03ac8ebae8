#include "cone_beam/view_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <string>
#include <utility>

#include "gicube/parallel_for.h"
#include "scene/names.h"

namespace gicube::samples {

HostRay clipped_ray(const Grid& grid, Vec3 source, Vec3 pixel) {
  const Vec3 from = to_voxels(grid, source);
  const HostRay line{
      .position = from, .direction = to_voxels(grid, pixel) - from, .length = std::numeric_limits<double>::infinity()};
  return clip_to_volume(line, grid.dims).value_or(HostRay{});
}

std::vector<HostRay> view_rays(const ConeGeometry& geometry, double angle, PixelRays of_pixel) {
  const Detector& detector = geometry.detector;
  const Pose at = pose(geometry, angle);
  const auto columns = static_cast<std::size_t>(detector.columns * of_pixel.u);
  const auto rows = static_cast<std::size_t>(detector.rows * of_pixel.v);
  std::vector<HostRay> rays(rows * columns);
  parallel_for(rows, 0, [&](std::size_t row) {
    const double v = v_of(detector, (static_cast<double>(row) + 0.5) / of_pixel.v - 0.5);
    for (std::size_t column = 0; column < columns; ++column) {
      const double u = u_of(detector, (static_cast<double>(column) + 0.5) / of_pixel.u - 0.5);
      rays[row * columns + column] =
          clipped_ray(geometry.volume, at.source, at.middle + u * at.along_u + v * at.along_v);
    }
  });
  return rays;
}

double length_in_space(const Grid& grid, const HostRay& ray) {
  if (ray.length <= 0) return 0;
  const Vec3 along = ray.direction, edge = grid.spacing;
  return ray.length * length(Vec3{along.x * edge.x, along.y * edge.y, along.z * edge.z}) / length(along);
}

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
  if (low == high) high = low + 1;  // nothing anywhere
  board.load_volume({.samples = std::as_bytes(values),
                     .type = SampleType::kFloat32,
                     .dims = grid.dims,
                     .spacing = grid.spacing,
                     .range = ValueRange{low, high},
                     .find_gradients = false});
}

std::uint64_t project_views(Board& board, const ConeGeometry& geometry, std::span<const double> angles, double step,
                            const std::function<void(std::size_t view, const std::vector<float>& values)>& take) {
  struct View {
    Ticket ticket;
    std::vector<HostRay> rays;        // that meet the volume
    std::vector<std::size_t> pixels;  // theirs
  };
  std::uint64_t rays = 0;
  const auto begin = [&](double angle) {
    View view;
    const std::vector<HostRay> all = view_rays(geometry, angle);
    for (std::size_t pixel = 0; pixel < all.size(); ++pixel) {
      if (all[pixel].length <= 0) continue;
      view.rays.push_back(all[pixel]);
      view.pixels.push_back(pixel);
    }
    rays += view.rays.size();
    view.ticket = board.submit(view.rays, {.type = RayType::kIntegral, .step = step});
    return view;
  };
  const std::size_t pixels = Projections{geometry.detector.columns, geometry.detector.rows, {}}.view_size();
  View next = begin(angles[0]);
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const View view = std::exchange(next, View());
    if (i + 1 < angles.size()) next = begin(angles[i + 1]);
    std::vector<TracedRay> traced(view.rays.size());
    board.receive(view.ticket, traced);
    const double low = board.value_range().low;
    std::vector<float> values(pixels);
    for (std::size_t k = 0; k < traced.size(); ++k) {
      const double below = low == 0 ? 0 : low * length_in_space(geometry.volume, view.rays[k]);
      values[view.pixels[k]] = static_cast<float>(traced[k].integral + below);
    }
    take(i, values);
  }
  return rays;
}

Projections project_by_board(Board& board, const ConeGeometry& geometry, std::span<const float> volume, double step,
                             const Progress& progress) {
  check(geometry);
  load_values(board, geometry.volume, volume);
  Projections out{geometry.detector.columns, geometry.detector.rows, {}};
  const auto told = [&, all = static_cast<std::uint32_t>(geometry.angles.size())](std::size_t done) {
    if (progress) progress(static_cast<std::uint32_t>(done), all);
  };
  told(0);
  project_views(board, geometry, geometry.angles, step, [&](std::size_t view, const std::vector<float>& values) {
    out.values.insert(out.values.end(), values.begin(), values.end());
    told(view + 1);
  });
  return out;
}

double max_of_a_voxel(const ConeGeometry& geometry, PixelRays rays) {
  const Vec3 edge = geometry.volume.spacing, corner = to_space(geometry.volume, {0, 0, 0});
  const Detector& detector = geometry.detector;
  const double longest = std::max({edge.x, edge.y, edge.z});
  const double nearest = (geometry.source_to_axis - std::hypot(corner.x, corner.y)) / geometry.source_to_detector;
  const double pixel = detector.pitch_u * detector.pitch_v * nearest * nearest / (rays.u * rays.v);
  return longest * std::max(1.0, longest * longest / pixel);
}

void make_up_for_faces(std::vector<float>& sums, const Dims& dims) {
  const auto half = [](int i, int dim) { return i == 0 || i == dim - 1 ? 2.0F : 1.0F; };
  float* sum = sums.data();
  for (int z = 0; z < dims[2]; ++z) {
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x) *sum++ *= half(x, dims[0]) * half(y, dims[1]) * half(z, dims[2]);
    }
  }
}

std::vector<float> backproject(Board& board, const ConeGeometry& geometry, std::span<const double> angles,
                               const Splatting& how, const ViewDensities& densities, Reconstruction& counts) {
  // A voxel that gets the most from all rays of all views near it has half of what a sum holds; and a step's most is 2^15 - 1
  // units, so that thousands of rays fit one command [chosen].
  constexpr double kMaxUnits = (1 << 15) - 1, kMaxSum = 8.0 * (1 << 30);
  const Vec3 edge = geometry.volume.spacing;
  const double of_a_step = std::max({edge.x, edge.y, edge.z}) * how.step / kMaxUnits;
  const double of_all = max_of_a_voxel(geometry, how.rays) * static_cast<double>(angles.size()) / kMaxSum;
  board.clear_sums(std::max(how.max_density, 1e-30) * std::max(of_a_step, of_all));

  constexpr std::size_t kUnderWay = 2;  // chosen: the board works at one view while the host makes the next
  std::deque<Ticket> under_way;
  const auto receive_down_to = [&](std::size_t left) {
    for (; under_way.size() > left; under_way.pop_front()) {
      const BatchReport report = board.receive(under_way.front());
      counts.deposits += report.deposits->samples;
      counts.overflowed += report.deposits->overflowed;
    }
  };
  for (std::size_t view = 0; view < angles.size(); ++view) {
    const std::vector<double> of_rays = densities(view);
    std::vector<HostRay> rays = view_rays(geometry, angles[view], how.rays);
    for (std::size_t i = 0; i < rays.size(); ++i) rays[i].energy = of_rays[i];
    std::erase_if(rays, [](const HostRay& ray) { return ray.length <= 0 || ray.energy == 0; });
    receive_down_to(kUnderWay - 1);
    counts.rays += rays.size();
    under_way.push_back(board.submit(rays, {.type = RayType::kBackproject, .step = how.step}));
  }
  receive_down_to(0);
  const Dims dims = geometry.volume.dims;
  std::vector<float> sums = board.read_sums({{0, 0, 0}, dims});
  make_up_for_faces(sums, dims);
  return sums;
}

}  // namespace gicube::samples

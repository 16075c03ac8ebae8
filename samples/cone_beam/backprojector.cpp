#include "cone_beam/backprojector.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cone_beam/threads.h"

namespace gicube::samples {

HostRay clipped_ray(const Grid& grid, Vec3 source, Vec3 pixel) {
  const Vec3 from = to_voxels(grid, source), way = to_voxels(grid, pixel) - from;
  const std::array<double, 3> start{from.x, from.y, from.z}, along{way.x, way.y, way.z};
  double first = 0, last = 1e30;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double end = grid.dims[axis] - 1;
    if (along[axis] == 0) {
      if (start[axis] < 0 || start[axis] > end) return {};
      continue;
    }
    const double one = -start[axis] / along[axis], other = (end - start[axis]) / along[axis];
    first = std::max(first, std::min(one, other));
    last = std::min(last, std::max(one, other));
  }
  if (last <= first) return {};
  const auto within = [&](double value, std::size_t axis) { return std::clamp(value, 0.0, grid.dims[axis] - 1.0); };
  const Vec3 entry = from + first * way;
  return {.position = {within(entry.x, 0), within(entry.y, 1), within(entry.z, 2)},
          .direction = way,
          .length = (last - first) * length(way)};
}

double max_of_a_voxel(const ConeGeometry& geometry, int fine) {
  const Vec3 edge = geometry.volume.spacing, corner = to_space(geometry.volume, {0, 0, 0});
  const Detector& detector = geometry.detector;
  const double longest = std::max({edge.x, edge.y, edge.z});
  const double nearest = (geometry.source_to_axis - std::hypot(corner.x, corner.y)) / geometry.source_to_detector;
  const double pixel = detector.pitch_u * detector.pitch_v * nearest * nearest / (fine * fine);
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

Backprojector::Backprojector(Board& board, const ConeGeometry& geometry, int fine, double step, double most,
                             std::size_t views)
    : board_(board), geometry_(geometry), fine_(fine), step_(step) {
  // A voxel that gets the most from all rays of all views near it has half of what a sum holds; and a step's most is 2^17 - 1
  // units, so that thousands of rays fit one command [chosen].
  constexpr double kMaxUnits = (1 << 17) - 1, kMaxSum = 8.0 * (1 << 30);
  const Vec3 edge = geometry.volume.spacing;
  const double of_a_step = std::max({edge.x, edge.y, edge.z}) * step / kMaxUnits;
  const double of_all = max_of_a_voxel(geometry, fine) * static_cast<double>(views) / kMaxSum;
  board_.clear_sums(std::max(most, 1e-30) * std::max(of_a_step, of_all));
}

void Backprojector::add(double angle, std::span<const double> densities) {
  const Detector& detector = geometry_.detector;
  const Pose at = pose(geometry_, angle);
  const auto columns = static_cast<std::size_t>(detector.columns * fine_);
  std::vector<HostRay> all(densities.size());
  in_parallel(densities.size() / columns, [&](std::size_t row) {
    const double v = v_of(detector, (static_cast<double>(row) + 0.5) / fine_ - 0.5);
    for (std::size_t column = 0; column < columns; ++column) {
      const double u = u_of(detector, (static_cast<double>(column) + 0.5) / fine_ - 0.5);
      HostRay& ray = all[row * columns + column];
      ray = clipped_ray(geometry_.volume, at.source, at.middle + u * at.along_u + v * at.along_v);
      ray.energy = densities[row * columns + column];
    }
  });
  std::erase_if(all, [](const HostRay& ray) { return ray.length <= 0 || ray.energy == 0; });
  constexpr std::size_t kUnderWay = 2;  // chosen: the board works at one view while the host makes the next
  while (under_way_.size() >= kUnderWay) receive();
  rays_ += all.size();
  under_way_.push_back(board_.submit(all, {.type = RayType::kBackproject, .step = step_}));
}

void Backprojector::receive() {
  const BatchReport report = board_.receive(under_way_.front());
  under_way_.erase(under_way_.begin());
  deposits_ += report.deposits->samples;
  overflowed_ += report.deposits->overflowed;
}

std::vector<float> Backprojector::finish() {
  while (!under_way_.empty()) receive();
  const Dims dims = geometry_.volume.dims;
  std::vector<float> sums = board_.read_sums({{0, 0, 0}, dims});
  make_up_for_faces(sums, dims);
  return sums;
}

}  // namespace gicube::samples

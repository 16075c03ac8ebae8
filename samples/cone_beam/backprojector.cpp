#include "cone_beam/backprojector.h"

#include <algorithm>
#include <cmath>

#include "cone_beam/view_rays.h"

namespace gicube::samples {

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
  std::vector<HostRay> all = view_rays(geometry_, angle, fine_);
  for (std::size_t i = 0; i < all.size(); ++i) all[i].energy = densities[i];
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

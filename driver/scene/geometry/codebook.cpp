#include "gicube/scene/voxeliser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace gicube::scene {
namespace {

constexpr double kGrid = 511;             // of the decoded components' 10 bits: finer differences are lost
constexpr std::size_t kMaxKinds = 32768;  // chosen: directions in use; limits the time to a second
constexpr int kRounds = 3;                // chosen: of Lloyd; more change little after farthest-point sampling

// The distinct directions, in a fixed order.
std::vector<Vec3> kinds_of(std::span<const float> gradients) {
  std::vector<std::array<std::int16_t, 3>> cells;
  for (std::size_t i = 0; i + 2 < gradients.size(); i += 3) {
    const Vec3 g{gradients[i], gradients[i + 1], gradients[i + 2]};
    const double norm = length(g);
    if (!(norm > 0)) continue;
    const auto cell = [norm](double v) { return static_cast<std::int16_t>(std::lround(kGrid * v / norm)); };
    cells.push_back({cell(g.x), cell(g.y), cell(g.z)});
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  const std::size_t stride = cells.size() / kMaxKinds + 1;
  std::vector<Vec3> kinds;
  for (std::size_t i = 0; i < cells.size(); i += stride) {
    kinds.push_back(normalise({double(cells[i][0]), double(cells[i][1]), double(cells[i][2])}));
  }
  return kinds;
}

// Each code is the direction farthest from all previous ones.
std::vector<Vec3> far_apart(const std::vector<Vec3>& kinds, std::size_t count) {
  std::vector<float> nearest(kinds.size(), -2);  // cosine to the nearest code
  std::vector<Vec3> codes;
  std::size_t next = 0;
  while (codes.size() < count) {
    codes.push_back(kinds[next]);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      nearest[i] = std::max(nearest[i], static_cast<float>(dot(kinds[i], codes.back())));
    }
    next = static_cast<std::size_t>(std::min_element(nearest.begin(), nearest.end()) - nearest.begin());
  }
  return codes;
}

void move_to_means(const std::vector<Vec3>& kinds, std::vector<Vec3>& codes) {
  std::vector<Vec3> sums(codes.size());
  for (const Vec3& kind : kinds) {
    double best = -2;
    std::size_t code = 0;
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const double cosine = dot(kind, codes[i]);
      if (cosine > best) best = cosine, code = i;
    }
    sums[code] = sums[code] + kind;
  }
  for (std::size_t i = 0; i < codes.size(); ++i) {
    if (length(sums[i]) > 1e-6) codes[i] = normalise(sums[i]);
  }
}

}  // namespace

std::vector<Vec3> codebook_of(std::span<const float> gradients) {
  const std::vector<Vec3> kinds = kinds_of(gradients);
  std::vector<Vec3> codes;
  if (kinds.size() < kCodes) {
    codes = kinds;
  } else {
    codes = far_apart(kinds, kCodes - 1);
    for (int round = 0; round < kRounds; ++round) move_to_means(kinds, codes);
  }
  codes.insert(codes.begin(), Vec3{});
  return codes;
}

}  // namespace gicube::scene

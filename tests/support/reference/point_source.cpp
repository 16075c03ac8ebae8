#include "point_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace gicube::reference {

namespace {

// Gauss and Legendre's six points on [-1, 1].
constexpr std::array<std::array<double, 2>, 6> kGauss{{{-0.9324695142031521, 0.1713244923791704},
                                                       {-0.6612093864662645, 0.3607615730481386},
                                                       {-0.2386191860831969, 0.4679139345726910},
                                                       {0.2386191860831969, 0.4679139345726910},
                                                       {0.6612093864662645, 0.3607615730481386},
                                                       {0.9324695142031521, 0.1713244923791704}}};
constexpr int kDeepest = 16;

using Integrand = std::function<double(Vec3)>;

double by_gauss(const Integrand& f, Vec3 low, Vec3 high) {
  const Vec3 middle = 0.5 * (low + high), half = 0.5 * (high - low);
  double sum = 0;
  for (const auto& [x, wx] : kGauss) {
    for (const auto& [y, wy] : kGauss) {
      for (const auto& [z, wz] : kGauss) sum += wx * wy * wz * f(middle + Vec3{x * half.x, y * half.y, z * half.z});
    }
  }
  return sum * half.x * half.y * half.z;
}

double distance_to_box(Vec3 p, Vec3 low, Vec3 high) {
  const Vec3 beside{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y}),
                    std::max({low.z - p.z, 0.0, p.z - high.z})};
  return length(beside);
}

// Boxes are cut in eight until they are smaller than their distance from the source. What is left out round the source
// itself, where the density is 1 / r^2, holds about its diameter's share.
double integrate(const Integrand& f, Vec3 source, Vec3 low, Vec3 high, int depth) {
  const Vec3 size = high - low;
  const double distance = distance_to_box(source, low, high);
  if (distance >= length(size)) return by_gauss(f, low, high);
  if (depth == kDeepest) return distance == 0 ? 0 : by_gauss(f, low, high);
  double sum = 0;
  for (int part = 0; part < 8; ++part) {
    const Vec3 from = low + Vec3{(part & 1) != 0 ? size.x / 2 : 0, (part & 2) != 0 ? size.y / 2 : 0,
                                 (part & 4) != 0 ? size.z / 2 : 0};
    sum += integrate(f, source, from, from + 0.5 * size, depth + 1);
  }
  return sum;
}

}  // namespace

double absorbed_density(double kappa, double r) {
  return kappa * std::exp(-kappa * r) / (4 * std::numbers::pi * r * r);
}

double absorbed_by_voxel(double kappa, Vec3 source, Vec3 voxel, Vec3 low, Vec3 high) {
  const Integrand weighted = [&](Vec3 p) {
    const Vec3 from = p - voxel;
    return (1 - std::abs(from.x)) * (1 - std::abs(from.y)) * (1 - std::abs(from.z)) *
           absorbed_density(kappa, length(p - source));
  };
  double sum = 0;
  for (int part = 0; part < 8; ++part) {  // on each of them the tent is smooth
    const Vec3 from =
        voxel - Vec3{(part & 1) != 0 ? 0.0 : 1.0, (part & 2) != 0 ? 0.0 : 1.0, (part & 4) != 0 ? 0.0 : 1.0};
    const Vec3 first{std::max(from.x, low.x), std::max(from.y, low.y), std::max(from.z, low.z)};
    const Vec3 last{std::min(from.x + 1, high.x), std::min(from.y + 1, high.y), std::min(from.z + 1, high.z)};
    if (first.x < last.x && first.y < last.y && first.z < last.z) sum += integrate(weighted, source, first, last, 0);
  }
  return sum;
}

}  // namespace gicube::reference

#include "cone_beam/charts/scans.h"

#include <fmt/format.h>

#include <numbers>
#include <utility>

namespace gicube::samples {

Phantom chart_head(double radius) {
  Phantom head = high_contrast_shepp_logan(radius);
  for (Ellipsoid& part : head) part.value *= 0.05;
  return head;
}

Phantom chart_discs() {
  Phantom discs;
  for (int i = -3; i <= 3; ++i) discs.push_back({0.05, {36, 36, 2}, {0, 0, i * kOutermostDisc / 3}, 0});
  return discs;
}

ConeGeometry chart_scan(int voxels, int pixels, int views) {
  ConeGeometry geometry;
  geometry.source_to_axis = 400;
  geometry.source_to_detector = 800;
  geometry.detector = {pixels, pixels, 200.0 / pixels, 200.0 / pixels};
  geometry.volume = {{voxels, voxels, voxels}, (90.0 / voxels) * Vec3{1, 1, 1}};
  geometry.angles = even_angles(views, 0.1, 2 * std::numbers::pi);
  return geometry;
}

Series case_series(const std::string& title, const std::string& prefix, const std::vector<double>& xs,
                   const std::function<Case(double x)>& case_at) {
  Series series{title, {}};
  for (const double x : xs) {
    series.points.push_back(
        {fmt::format("{}/{:g}", prefix, x), [what = case_at(x), x](Runner& runner) {
           const auto [made, error, board_ms, bus_ms] = runner.run(what);
           const double residual = made.residuals.empty() ? 0 : made.residuals.back();
           return fmt::format("{:g},{:.5g},{:.4g},{:.5g},{:.4g},{:.4g},{:.1f},{:.1f},{},{},{:.4g},{:.4g},{},{}\n", x,
                              error.rmse, error.bias, error.relative_l2, error.psnr, error.ssim, board_ms, bus_ms,
                              made.rays, made.deposits, made.clipped, residual, made.iterations, made.diverged ? 1 : 0);
         }});
  }
  return series;
}

}  // namespace gicube::samples

// Mid-plane profiles of the scans that the method is judged by: 128^3 from 180 and 256^3 from 360 views of 256^2 pixels.
#include <fmt/format.h>

#include <numbers>
#include <string>
#include <variant>

#include "cone_beam/charts/scans.h"

namespace gicube::samples {
namespace {

Case large(const Phantom& phantom, int voxels, int views) {
  const ConeGeometry geometry{.source_to_axis = 500,
                              .source_to_detector = 1000,
                              .detector = {256, 256, 400.0 / 256, 400.0 / 256},
                              .volume = {{voxels, voxels, voxels}, (180.0 / voxels) * Vec3{1, 1, 1}},
                              .angles = even_angles(views, 0, 2 * std::numbers::pi)};
  return {phantom, geometry, FdkSettings{}, {85, 45}};
}

// Along x through the middle: place, phantom, result without and with normalising.
std::string rows(Case what, Runner& runner) {
  const Grid& grid = what.geometry.volume;
  const Dims middle{0, grid.dims[1] / 2, grid.dims[2] / 2};
  const auto through = [&](const std::vector<float>& values) { return profile(grid, values, 0, middle); };
  const auto truth = through(voxels(what.phantom, grid)), plain = through(runner.reconstruct(what).values);
  std::get<FdkSettings>(what.method).normalise = true;
  const auto normalised = through(runner.reconstruct(what).values);
  std::string text;
  for (std::size_t x = 0; x < truth.size(); ++x) {
    const double place = to_space(grid, {static_cast<double>(x), 0, 0}).x;
    text += fmt::format("{:.4f},{:.5f},{:.5f},{:.5f}\n", place, truth[x], plain[x], normalised[x]);
  }
  return text;
}

}  // namespace

Chart profile_chart() {
  Chart chart{"profile", "x,truth,value,normalised", {}};
  for (const auto& [voxels, views] : {std::pair{128, 180}, {256, 360}}) {
    for (const auto& [name, phantom] : {std::pair{"sphere", uniform_sphere(70, 1)}, {"head", shepp_logan(85)}}) {
      const Case what = large(phantom, voxels, views);
      chart.series.push_back(
          {fmt::format("{} of {}^3 from {} views", name, voxels, views),
           {{fmt::format("profile/{}/{}", name, voxels), [what](Runner& runner) { return rows(what, runner); }}}});
    }
  }
  return chart;
}

}  // namespace gicube::samples

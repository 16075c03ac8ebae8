// What scan and method do to the result: cone angle, truncation, few views, words, iterations, relaxation; and profiles of whole scans.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>

#include "cone_beam/charts/charts.h"

namespace gicube::samples {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
const AlgebraicSettings kSart{.iterations = 4, .relaxation = 0.3};
constexpr double kHalfHeight = 40;  // of what is seen under the cone angle

// The object stays, the source comes nearer; the detector, whose pixels are as large at the axis, sees all of it.
Case cone(double degrees, const Phantom& phantom = chart_discs(),
          const std::variant<FdkSettings, AlgebraicSettings>& method = kPlainFdk) {
  Case what{phantom, chart_scan(64, 96, 120), method, {34, 40}};
  ConeGeometry& geometry = what.geometry;
  geometry.source_to_axis = kHalfHeight / std::tan(degrees / 2 * kDegree);
  geometry.source_to_detector = 2 * geometry.source_to_axis;
  geometry.detector = {96, 112, 2.5, 2.5};
  return what;
}

// Of values within `radius` of the axis, the mean in each slice.
std::vector<double> slice_means(const Grid& grid, const std::vector<float>& values, double radius) {
  const auto slices = static_cast<std::size_t>(grid.dims[2]);
  std::vector<double> sums(slices), counts(slices);
  std::size_t i = 0;
  for (std::size_t z = 0; z < slices; ++z) {
    for_each_in_slice(grid, z, [&](Vec3 at) {
      const double value = static_cast<double>(values[i++]);
      if (std::hypot(at.x, at.y) <= radius) sums[z] += value, ++counts[z];
    });
    sums[z] /= counts[z];
  }
  return sums;
}

// z, and the means of truth and result within 8 and 34 mm of the axis.
std::string axial_rows(const Case& what, Runner& runner) {
  const Grid& grid = what.geometry.volume;
  const std::vector<float> values = runner.reconstruct(what).values, truth = voxels(what.phantom, grid);
  const auto inner = slice_means(grid, values, 8), outer = slice_means(grid, values, 34),
             real = slice_means(grid, truth, 34);
  std::string rows;
  for (std::size_t z = 0; z < real.size(); ++z) {
    const double place = to_space(grid, {0, 0, double(z)}).z;
    rows += fmt::format("{:.3f},{:.4f},{:.5f},{:.5f}\n", place, real[z], inner[z], outer[z]);
  }
  return rows;
}

// A detector that sees the part `seen` of the head's width at the axis; compared is what half of it sees.
Case truncated(double seen, const std::variant<FdkSettings, AlgebraicSettings>& method) {
  constexpr double kWidth = 2 * 42 * 0.92;  // of the head, at its widest
  Case what{chart_head(), chart_scan(64, 96, 120), method, {0.5 * kWidth / 2 * 0.9, 20}};
  Detector& detector = what.geometry.detector;
  detector.columns = static_cast<int>(std::lround(seen * kWidth * 2 / detector.pitch_u));
  return what;
}

// The scans that the method is judged by: 128^3 from 180 and 256^3 from 360 views of 256^2 pixels.
Case large(const Phantom& phantom, int voxels, int views) {
  const ConeGeometry geometry{.source_to_axis = 500,
                              .source_to_detector = 1000,
                              .detector = {256, 256, 400.0 / 256, 400.0 / 256},
                              .volume = {{voxels, voxels, voxels}, (180.0 / voxels) * Vec3{1, 1, 1}},
                              .angles = even_angles(views, 0, 2 * std::numbers::pi)};
  return {phantom, geometry, kPlainFdk, {85, 45}};
}

// Along x through the middle: place, phantom, result without and with normalising.
std::string profile_rows(Case what, Runner& runner) {
  const Grid& grid = what.geometry.volume;
  const Dims middle{0, grid.dims[1] / 2, grid.dims[2] / 2};
  const auto through = [&](const std::vector<float>& values) { return profile(grid, values, 0, middle); };
  const auto truth = through(voxels(what.phantom, grid)), plain = through(runner.reconstruct(what).values);
  std::get<FdkSettings>(what.method).normalise = true;
  const auto normalised = through(runner.reconstruct(what).values);
  std::string text;
  for (std::size_t x = 0; x < truth.size(); ++x) {
    const double place = to_space(grid, {double(x), 0, 0}).x;
    text += fmt::format("{:.4f},{:.5f},{:.5f},{:.5f}\n", place, truth[x], plain[x], normalised[x]);
  }
  return text;
}

constexpr int kViews = 120;

Case words(const FdkSettings& settings, std::vector<std::string> board = {}) {
  return {chart_head(), chart_scan(64, 96, kViews), settings, {40, 20}, 0, std::move(board)};
}

Case noisy_or_not(const std::variant<FdkSettings, AlgebraicSettings>& method, double photons) {
  return {chart_head(), chart_scan(64, 96, 60), method, {40, 20}, photons};
}

struct Algebraic {
  const char *name, *title;
  Method method;
  double relaxation;  // of sart_chart()
};
constexpr Algebraic kAlgebraic[]{{"sart", "SART", Method::kSart, 0.3},
                                 {"os_sart", "OS-SART 10 x 6", Method::kOsSart, 1.0},
                                 {"sirt", "SIRT", Method::kSirt, 1.8}};

Chart accumulator_chart() {
  // Of irradiance words, with one setting changed to x.
  const auto by = [](auto FdkSettings::*setting, const std::vector<std::string>& board = {}) {
    return [=](double x) {
      FdkSettings settings = kPlainFdk;
      settings.accumulator = Accumulator::kIrradiance;
      settings.*setting = static_cast<std::remove_reference_t<decltype(settings.*setting)>>(x);
      return words(settings, board);
    };
  };
  return {"accumulator",
          kCaseColumns,
          {case_series("sums of 36 bits", "accumulator/sums", {kViews}, [](double) { return words(kPlainFdk); }),
           case_series("11 bits read every x views", "accumulator/read_every", {1, 2, 4, 8, 20, 40, kViews},
                       by(&FdkSettings::read_every)),
           case_series("x bits read every 8 views", "accumulator/bits", {8, 10, 11, 12, 14, 16},
                       by(&FdkSettings::bits, {"asic.datapath=wide"})),
           case_series("11 bits full at x of the bound", "accumulator/headroom", {1.0, 0.5, 0.25, 0.12, 0.06, 0.03},
                       by(&FdkSettings::headroom))}};
}

Chart sart_chart() {
  Chart chart{"sart", kCaseColumns, {}};
  for (const double photons : {0.0, 3000.0}) {
    const std::string noise = photons > 0 ? "_noisy" : "_noiseless", end = photons > 0 ? " of 3000 photons" : "";
    chart.series.push_back(case_series("FDK by Ram-Lak / Shepp-Logan / Hann" + end, "sart/fdk" + noise, {1, 2, 3},
                                       [photons](double which) {
                                         FdkSettings settings = kPlainFdk;
                                         settings.window = static_cast<Window>(static_cast<int>(which) - 1);
                                         return noisy_or_not(settings, photons);
                                       }));
    for (const auto& [name, title, method, relaxation] : kAlgebraic) {
      AlgebraicSettings settings{.method = method, .subsets = 10, .relaxation = relaxation};
      chart.series.push_back(case_series(fmt::format("{} by {:.1f}{}", title, relaxation, end),
                                         "sart/" + (name + noise), {1, 2, 4, 8, 16},
                                         [settings, photons](double iterations) mutable {
                                           settings.iterations = static_cast<int>(iterations);
                                           return noisy_or_not(settings, photons);
                                         }));
    }
  }
  return chart;
}

Chart relaxation_chart() {
  Chart chart{"relaxation", kCaseColumns, {}};
  for (const auto& [name, title, method, ignored] : kAlgebraic) {
    AlgebraicSettings settings{.method = method, .iterations = 6, .subsets = 10};
    chart.series.push_back(case_series(title, std::string("relaxation/") + name,
                                       {0.1, 0.3, 1.0, 1.5, 1.9, 2.0, 2.2, 2.5, 3.0},
                                       [settings](double relaxation) mutable {
                                         settings.relaxation = relaxation;
                                         return Case{chart_head(), chart_scan(48, 64, 60), settings, {40, 20}};
                                       }));
  }
  return chart;
}

}  // namespace

Chart cone_angle_chart() {
  const std::vector<double> degrees{5, 10, 15, 20, 25, 30, 35, 40};
  return {"cone_angle",
          kCaseColumns,
          {case_series("discs by FDK", "cone_angle/fdk", degrees, [](double x) { return cone(x); }),
           case_series("discs by SART", "cone_angle/sart", {5, 20, 40},
                       [](double x) { return cone(x, chart_discs(), kSart); }),
           case_series("head by FDK", "cone_angle/head", degrees, [](double x) { return cone(x, chart_head()); })}};
}

Chart axial_profile_chart() {
  Chart chart{"axial_profile", "z,truth,within_8,within_34", {}};
  for (const double degrees : {5, 10, 20, 30, 40}) {
    const Case what = cone(degrees);
    chart.series.push_back({fmt::format("{} degrees", degrees),
                            {{fmt::format("axial_profile/fdk/{}", degrees),
                              [what](Runner& runner) { return axial_rows(what, runner); }}}});
  }
  return chart;
}

Chart truncation_chart() {
  return {"truncation",
          kCaseColumns,
          {case_series("FDK", "truncation/fdk", {1.2, 1.0, 0.9, 0.8, 0.7, 0.6, 0.5},
                       [](double seen) { return truncated(seen, kPlainFdk); }),
           case_series("SART", "truncation/sart", {1.2, 0.9, 0.7, 0.5},
                       [](double seen) { return truncated(seen, kSart); })}};
}

Chart views_chart() {
  const auto from = [](double views, const std::variant<FdkSettings, AlgebraicSettings>& method) {
    return Case{chart_head(), chart_scan(64, 96, static_cast<int>(views)), method, {40, 20}};
  };
  return {"views",
          kCaseColumns,
          {case_series("FDK", "views/fdk", {20, 40, 60, 90, 120, 180, 360, 720},
                       [&](double views) { return from(views, kPlainFdk); }),
           case_series("SART", "views/sart", {20, 40, 60, 90, 180}, [&](double views) { return from(views, kSart); })}};
}

Chart profile_chart() {
  Chart chart{"profile", "x,truth,value,normalised", {}};
  for (const auto& [voxels, views] : {std::pair{128, 180}, {256, 360}}) {
    for (const auto& [name, phantom] : {std::pair{"sphere", uniform_sphere(70, 1)}, {"head", shepp_logan(85)}}) {
      const Case what = large(phantom, voxels, views);
      chart.series.push_back({fmt::format("{} of {}^3 from {} views", name, voxels, views),
                              {{fmt::format("profile/{}/{}", name, voxels),
                                [what](Runner& runner) { return profile_rows(what, runner); }}}});
    }
  }
  return chart;
}

std::vector<Chart> cone_beam_charts() {
  return {cone_angle_chart(),  axial_profile_chart(), truncation_chart(), views_chart(),      moire_chart(),
          ray_spacing_chart(), accumulator_chart(),   sart_chart(),       relaxation_chart(), profile_chart()};
}

}  // namespace gicube::samples

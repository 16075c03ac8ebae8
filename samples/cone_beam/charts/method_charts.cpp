// What the method's own settings do: words, iterations, relaxation.
#include <fmt/format.h>

#include <string>
#include <utility>

#include "cone_beam/charts/failures.h"
#include "cone_beam/charts/scans.h"

namespace gicube::samples {
namespace {

constexpr int kViews = 120;
const std::string kWide = "asic.datapath=wide";

Case words(const FdkSettings& settings, std::vector<std::string> board = {}) {
  return {chart_head(), chart_scan(64, 96, kViews), settings, {40, 20}, 0, std::move(board)};
}

Case noisy_or_not(const std::variant<FdkSettings, AlgebraicSettings>& method, double photons) {
  return {chart_head(), chart_scan(64, 96, 60), method, {40, 20}, photons};
}

}  // namespace

Chart accumulator_chart() {
  Chart chart{"accumulator", kCaseColumns, {}};
  Series sums{"sums of 36 bits", {}}, paper{"11 bits read every x views", {}}, wide{"x bits read every 8 views", {}},
      headroom{"11 bits full at x of the bound", {}};
  sums.points.push_back(case_point(chart.name, "sums", kViews, words({})));
  for (const int every : {1, 2, 4, 8, 20, 40, kViews}) {
    const FdkSettings settings{.accumulator = Accumulator::kIrradiance, .read_every = every};
    paper.points.push_back(case_point(chart.name, "read_every", every, words(settings)));
  }
  for (const int bits : {8, 10, 11, 12, 14, 16}) {
    const FdkSettings settings{.accumulator = Accumulator::kIrradiance, .read_every = 8, .bits = bits};
    wide.points.push_back(case_point(chart.name, "bits", bits, words(settings, {kWide})));
  }
  for (const double part : {1.0, 0.5, 0.25, 0.12, 0.06, 0.03}) {
    const FdkSettings settings{.accumulator = Accumulator::kIrradiance, .read_every = 8, .headroom = part};
    headroom.points.push_back(case_point(chart.name, "headroom", part, words(settings)));
  }
  chart.series = {sums, paper, wide, headroom};
  return chart;
}

Chart sart_chart() {
  Chart chart{"sart", kCaseColumns, {}};
  constexpr double kPhotons = 3000;
  for (const double photons : {0.0, kPhotons}) {
    const std::string noise = photons > 0 ? "noisy" : "noiseless", end = photons > 0 ? " of 3000 photons" : "";
    Series fdk{"FDK by Ram-Lak / Shepp-Logan / Hann" + end, {}};
    int which = 1;
    for (const Window window : {Window::kRamLak, Window::kSheppLogan, Window::kHann}) {
      fdk.points.push_back(
          case_point(chart.name, "fdk_" + noise, which++, noisy_or_not(FdkSettings{.window = window}, photons)));
    }
    chart.series.push_back(fdk);
    for (const auto& [name, method, relaxation] :
         {std::tuple{"sart", Method::kSart, 0.3}, {"os_sart", Method::kOsSart, 1.0}, {"sirt", Method::kSirt, 1.8}}) {
      const char* title = method == Method::kSart   ? "SART by 0.3"
                          : method == Method::kSirt ? "SIRT by 1.8"
                                                    : "OS-SART 10 x 6 by 1.0";
      Series series{title + end, {}};
      for (const int iterations : {1, 2, 4, 8, 16}) {
        const AlgebraicSettings settings{
            .method = method, .iterations = iterations, .subsets = 10, .relaxation = relaxation};
        series.points.push_back(
            case_point(chart.name, std::string(name) + "_" + noise, iterations, noisy_or_not(settings, photons)));
      }
      chart.series.push_back(std::move(series));
    }
  }
  return chart;
}

Chart relaxation_chart() {
  Chart chart{"relaxation", kCaseColumns, {}};
  for (const auto& [name, title, method] : {std::tuple{"sart", "SART", Method::kSart},
                                            {"os_sart", "OS-SART 10 x 6", Method::kOsSart},
                                            {"sirt", "SIRT", Method::kSirt}}) {
    Series series{title, {}};
    for (const double relaxation : {0.1, 0.3, 1.0, 1.5, 1.9, 2.0, 2.2, 2.5, 3.0}) {
      const AlgebraicSettings settings{.method = method, .iterations = 6, .subsets = 10, .relaxation = relaxation};
      const Case what{chart_head(), chart_scan(48, 64, 60), settings, {40, 20}};
      series.points.push_back(case_point(chart.name, name, relaxation, what));
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

std::vector<Chart> cone_beam_charts() {
  return {cone_angle_chart(),  axial_profile_chart(), truncation_chart(), views_chart(),      moire_chart(),
          ray_spacing_chart(), accumulator_chart(),   sart_chart(),       relaxation_chart(), profile_chart()};
}

}  // namespace gicube::samples

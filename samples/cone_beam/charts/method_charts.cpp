// What the method's own settings do: words, iterations, relaxation.
#include <fmt/format.h>

#include <string>
#include <type_traits>
#include <utility>

#include "cone_beam/charts/charts.h"

namespace gicube::samples {
namespace {

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
      FdkSettings settings{.accumulator = Accumulator::kIrradiance};
      settings.*setting = static_cast<std::remove_reference_t<decltype(settings.*setting)>>(x);
      return words(settings, board);
    };
  };
  return {"accumulator",
          kCaseColumns,
          {case_series("sums of 36 bits", "accumulator/sums", {kViews}, [](double) { return words({}); }),
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
                                         const auto window = static_cast<Window>(static_cast<int>(which) - 1);
                                         return noisy_or_not(FdkSettings{.window = window}, photons);
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

std::vector<Chart> cone_beam_charts() {
  return {cone_angle_chart(),  axial_profile_chart(), truncation_chart(), views_chart(),      moire_chart(),
          ray_spacing_chart(), accumulator_chart(),   sart_chart(),       relaxation_chart(), profile_chart()};
}

}  // namespace gicube::samples

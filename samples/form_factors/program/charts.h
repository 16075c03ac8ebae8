// gicube-form-factors charts: the tables that script/charts draws.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "form_factors/program/options.h"
#include "form_factors/program/visibility.h"
#include "scene/program/progress.h"

namespace gicube::samples {

// The error of form factors by their number of rays: root mean square of F / exact - 1 over independent estimates.
struct ErrorCurve {
  std::string name;                 // of the pair of elements
  double exact = 0;                 // F, or the mean of 1 / r^2
  std::vector<std::uint32_t> rays;  // of an estimate
  std::vector<double> errors;
  double slope = 0;  // of a straight line through log(error) over log(rays)
};

// Parallel squares a side apart, clear and in a medium; perpendicular ones with a common edge, plain and cut into strips that grow
// with their distance from it; boxes whose centres are two sides apart. `max_rays`: a power of two, 64 or more.
// `point`: the name of the only point that is wanted, error/CURVE/RAYS; empty: all.
std::vector<ErrorCurve> closed_form_curves(Board& board, std::uint32_t max_rays, const std::string& point = "");

// Light between random voxels by one board and one way to make its rays.
struct TradePoint {
  std::string bus;
  PairRays made = PairRays::kByBoard;
  std::uint32_t rays = 0;  // a pair
  double error = 0;        // of the pairs' transmittances: root mean square from those of many rays
  Visibility seen;
};

// Writes FOLDER/form_factors_error.csv, _slopes.csv, _trade.csv and _hierarchy.csv, each row but the slopes' with the command that
// makes it again; or prints one point's row. Throws as solve(), and InputError if there is no such point.
void form_factor_charts(const FormFactorChartOptions& options, ProgressLine& progress);

}  // namespace gicube::samples

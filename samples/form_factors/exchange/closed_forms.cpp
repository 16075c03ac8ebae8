#include "form_factors/exchange/closed_forms.h"

#include <cmath>
#include <numbers>

namespace gicube::samples {
namespace {

constexpr int kIntervals = 128;  // of Simpson's rule, even

// Of f over 0..1.
template <typename Function>
double integral(const Function& f) {
  double sum = 0;
  for (int i = 0; i <= kIntervals; ++i) {
    const int weight = i == 0 || i == kIntervals ? 1 : i % 2 == 1 ? 4 : 2;
    sum += weight * f(static_cast<double>(i) / kIntervals);
  }
  return sum / (3.0 * kIntervals);
}

}  // namespace

// In a medium: the four coordinates come in by two differences x and y alone, whose densities are 1 - |x|.
double parallel_squares(double kappa) {
  const double pi = std::numbers::pi;
  if (kappa == 0) {
    return 2 / pi *
           (std::log(std::sqrt(4.0 / 3)) + 2 * std::numbers::sqrt2 * std::atan(1 / std::numbers::sqrt2) - pi / 2);
  }
  return 4 * integral([&](double x) {
           return (1 - x) * integral([&](double y) {
                    const double square = x * x + y * y + 1;
                    return (1 - y) * std::exp(-kappa * std::sqrt(square)) / (pi * square * square);
                  });
         });
}

double perpendicular_squares() {
  const double pi = std::numbers::pi, root = std::numbers::sqrt2;
  return (pi / 2 - root * std::atan(1 / root) + 0.25 * std::log(4.0 / 3 * 0.75 * 0.75)) / pi;
}

double mean_inverse_square(double distance) {
  const auto along = [&](double z) {
    return 4 * integral([&](double x) {
             return (1 - x) * integral([&](double y) { return (1 - y) / (x * x + y * y + z * z); });
           });
  };
  return integral([&](double z) { return (1 - z) * (along(distance + z) + along(distance - z)); });
}

}  // namespace gicube::samples

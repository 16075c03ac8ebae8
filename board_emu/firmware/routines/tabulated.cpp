#include <algorithm>
#include <cmath>

#include "firmware/routines/built_in.h"
#include "words/vectors.h"

namespace gicube::emu {

namespace {

std::optional<std::string> fault(std::span<const float> parameters) {
  if (parameters.empty()) return "phase function: expected 1 to 32 values, got none";
  double sum = 0;
  for (const float value : parameters) {
    if (!(value >= 0) || !std::isfinite(value)) {
      return "phase function: expected finite values of at least 0, got " + std::to_string(value);
    }
    sum += value;
  }
  if (sum > 0) return std::nullopt;
  return "phase function: expected a value above 0, got only zeros";
}

// The cosine at which the function's integral from -1 reaches the fraction `chance` of the whole.
double cosine_at(double chance, std::span<const float> f) {
  if (f.size() == 1) return 2 * chance - 1;
  double all = 0;
  for (std::size_t i = 1; i < f.size(); ++i) all += (double{f[i - 1]} + f[i]) / 2;
  double left = chance * all;
  std::size_t i = 0, last = 0;
  for (; i + 1 < f.size(); ++i) {
    const double area = (double{f[i]} + f[i + 1]) / 2;
    if (area > 0) last = i;
    if (left < area) break;
    left -= area;
  }
  double part = 1;  // of segment i; rounding can bring `left` to the end of all areas
  if (i + 1 == f.size()) {
    i = last;
  } else {  // solves a t + (b - a) t^2 / 2 = left, in the form without cancellation
    const double a = f[i], b = f[i + 1];
    const double root = a + std::sqrt(std::fmax(0.0, a * a + 2 * (b - a) * left));
    part = root > 0 ? std::min(1.0, 2 * left / root) : 0;
  }
  return 2 * (static_cast<double>(i) + part) / static_cast<double>(f.size() - 1) - 1;
}

ScatterAnswer scatter(const ScatterEvent& event) {
  return {.direction = around(event.direction, cosine_at(event.random[0], event.parameters), event.random[1]),
          .cycles = kBuiltInCycles};
}

}  // namespace

const BuiltIn kTabulated{"tabulated", fault, scatter};

const BuiltIn* built_in(std::uint8_t number) {
  switch (number) {  // as in the driver's BoardRoutine (material.h)
    case 0: return &kFresnel;
    case 1: return &kHenyeyGreenstein;
    case 2: return &kTabulated;
    default: return nullptr;
  }
}

}  // namespace gicube::emu

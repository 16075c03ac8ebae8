#include <algorithm>
#include <cmath>

#include "firmware/routines/built_in.h"
#include "words/vectors.h"

namespace gicube::emu {

namespace {

std::optional<std::string> fault(std::span<const float> parameters) {
  if (parameters.size() > 1) return "expected 1 parameter, got " + std::to_string(parameters.size());
  if (parameters.empty() || std::fabs(parameters[0]) < 1) return std::nullopt;  // false for NaN
  return "g: expected more than -1 and less than 1, got " + std::to_string(parameters[0]);
}

ScatterAnswer scatter(const ScatterEvent& event) {
  const double g = event.parameters.empty() ? 0 : event.parameters[0], chance = event.random[0];
  double cosine = 2 * chance - 1;
  if (std::fabs(g) > 1e-4) {  // chosen: a smaller g cancels in the inversion, and changes the function by under 3e-4
    const double root = (1 - g * g) / (1 - g + 2 * g * chance);
    cosine = std::clamp((1 + g * g - root * root) / (2 * g), -1.0, 1.0);
  }
  return {.direction = around(event.direction, cosine, event.random[1]), .cycles = kBuiltInCycles};
}

}  // namespace

const BuiltIn kHenyeyGreenstein{"henyey_greenstein", fault, scatter};

}  // namespace gicube::emu

#include <cmath>

#include "firmware/routines/built_in.h"
#include "words/vectors.h"

namespace gicube::emu {

namespace {

constexpr float kGlass = 1.5f;                          // chosen
constexpr float kMinIndex = 0.01f, kMaxIndex = 100.0f;  // chosen: beyond any material

std::optional<std::string> fault(std::span<const float> parameters) {
  if (parameters.size() > 1) return "expected 1 parameter, got " + std::to_string(parameters.size());
  if (parameters.empty()) return std::nullopt;
  if (parameters[0] >= kMinIndex && parameters[0] <= kMaxIndex) return std::nullopt;
  return "index of refraction: expected 0.01..100, got " + std::to_string(parameters[0]);
}

ScatterAnswer scatter(const ScatterEvent& event) {
  ScatterAnswer answer{.direction = event.direction, .cycles = kBuiltInCycles};
  if (event.normal == Vector{}) return answer;
  const double index = event.parameters.empty() ? kGlass : event.parameters[0];
  const double slope = dot(event.direction, event.normal);
  const bool enters = slope < 0;
  const double from = enters ? 1 : index, to = enters ? index : 1;
  const double cosine = std::fmin(std::fabs(slope), 1.0);
  if (event.random[0] < fresnel_reflectance(cosine, from, to)) {
    answer.direction = along(event.direction, -2 * slope, event.normal);
    return answer;
  }
  const double eta = from / to;
  const double refracted = std::sqrt(std::fmax(0.0, 1 - eta * eta * (1 - cosine * cosine)));
  Vector bent{};
  for (std::size_t i = 0; i < 3; ++i) {  // the tangential part is scaled by eta; the rest crosses the surface
    const double tangential = event.direction[i] - slope * event.normal[i];
    bent[i] = eta * tangential + (enters ? -refracted : refracted) * event.normal[i];
  }
  answer.direction = bent;
  return answer;
}

}  // namespace

double fresnel_reflectance(double cosine, double index_from, double index_to) {
  const double eta = index_from / index_to, sine_squared = eta * eta * (1 - cosine * cosine);
  if (sine_squared >= 1) return 1;
  const double refracted = std::sqrt(1 - sine_squared);
  const double across = (index_from * cosine - index_to * refracted) / (index_from * cosine + index_to * refracted);
  const double parallel = (index_to * cosine - index_from * refracted) / (index_to * cosine + index_from * refracted);
  return (across * across + parallel * parallel) / 2;
}

const BuiltIn kFresnel{"fresnel", fault, scatter};

}  // namespace gicube::emu

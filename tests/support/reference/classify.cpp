#include "classify.h"

#include <cmath>

namespace gicube::reference {

namespace {

constexpr double kColourOne = 4095;    // 12 bits
constexpr double kOpacityOne = 65535;  // 16 bits
constexpr double kDensityMax = 4095;

// The last of the points that are not after `value`, the next one, and the way from the one to the other, 0..1.
template <typename Point>
struct Between {
  const Point* from;
  const Point* to;
  double way;
};

template <typename Point>
Between<Point> find(const std::vector<Point>& points, double value) {
  if (value < points.front().value) return {&points.front(), &points.front(), 0};
  std::size_t i = 0;
  while (i + 1 < points.size() && points[i + 1].value <= value) ++i;
  if (i + 1 == points.size()) return {&points[i], &points[i], 0};
  return {&points[i], &points[i + 1], (value - points[i].value) / (points[i + 1].value - points[i].value)};
}

double mix(double a, double b, double w) { return (1 - w) * a + w * b; }

std::array<double, 3> colour_at(const TransferFunction& function, double value) {
  const auto [from, to, way] = find(function.colours, value);
  return {mix(from->colour[0], to->colour[0], way), mix(from->colour[1], to->colour[1], way),
          mix(from->colour[2], to->colour[2], way)};
}

double opacity_at(const TransferFunction& function, double value) {
  const auto [from, to, way] = find(function.opacities, value);
  return mix(from->opacity, to->opacity, way);
}

}  // namespace

Material classify(const TransferFunction& function, const Sample& sample, ValueRange range,
                  const Quantisers& quantisers) {
  if (function.colours.empty() || function.opacities.empty()) return {};
  const double index = std::floor(sample.density + 0.5);
  const double indexed = range.low + index / kDensityMax * (range.high - range.low);
  Material material{colour_at(function, quantisers.colour ? indexed : sample.value),
                    opacity_at(function, quantisers.opacity ? indexed : sample.value)};
  if (quantisers.colour) {
    for (double& c : material.colour) c = std::round(c * kColourOne) / kColourOne;
  }
  if (quantisers.opacity) material.opacity = std::round(material.opacity * kOpacityOne) / kOpacityOne;
  return material;
}

}  // namespace gicube::reference

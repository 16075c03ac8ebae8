#include "cone_beam/scan/scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gicube/scene/error.h"

namespace gicube::samples {
namespace {

// One view, in double precision.
std::vector<double> mean(const Stack& stack, const Stack& views, const char* name, double otherwise) {
  const std::size_t size = views.view_size();
  if (stack.values.empty()) return std::vector<double>(size, otherwise);
  if (stack.columns != views.columns || stack.rows != views.rows) {
    throw InputError(name, fmt::format("{} x {} pixels, as the projections have", views.columns, views.rows),
                     fmt::format("{} x {}", stack.columns, stack.rows));
  }
  std::vector<double> out(size);
  for (std::size_t i = 0; i < stack.values.size(); ++i) out[i % size] += static_cast<double>(stack.values[i]);
  for (double& value : out) value /= static_cast<double>(stack.views());
  return out;
}

// The mean of the next pixels in the row that are not dead; 0 in a row without any.
float beside(const std::vector<double>& light, const float* view, std::size_t pixel, std::size_t columns) {
  const std::size_t begin = pixel - pixel % columns, end = begin + columns;
  double sum = 0;
  int count = 0;
  const auto take = [&](std::size_t i) {
    if (light[i] > 0) sum += static_cast<double>(view[i]), ++count;
    return light[i] > 0;
  };
  for (std::size_t i = pixel; i > begin && !take(i - 1);) --i;
  for (std::size_t i = pixel + 1; i < end && !take(i);) ++i;
  return count == 0 ? 0.0F : static_cast<float>(sum / count);
}

}  // namespace

FlatFieldReport correct_flat_field(Stack& views, const Stack& flats, const Stack& darks, double full) {
  if (flats.values.empty() && !(full > 0 && std::isfinite(full))) {
    throw InputError("full", "the intensity of a ray that met nothing, above 0, where there are no flats",
                     fmt::format("{}", full));
  }
  const std::vector<double> dark = mean(darks, views, "darks", 0);
  std::vector<double> light = mean(flats, views, "flats", full);
  FlatFieldReport report;
  for (std::size_t i = 0; i < light.size(); ++i) {
    light[i] -= dark[i];
    if (light[i] <= 0) ++report.dead;
  }
  if (report.dead == light.size()) throw InputError("flats", "some pixel that is lighter than its dark", "none");
  for (std::size_t view = 0; view < views.views(); ++view) {
    float* const values = views.values.data() + view * light.size();
    for (std::size_t i = 0; i < light.size(); ++i) {
      if (light[i] <= 0) continue;
      const double least = views.counts ? 0.5 : 1e-6 * light[i];  // chosen
      const double left = static_cast<double>(values[i]) - dark[i];
      if (left < least) ++report.absorbed;
      values[i] = static_cast<float>(-std::log(std::max(left, least) / light[i]));
    }
    for (std::size_t i = 0; report.dead > 0 && i < light.size(); ++i) {
      if (light[i] <= 0) values[i] = beside(light, values, i, static_cast<std::size_t>(views.columns));
    }
  }
  return report;
}

}  // namespace gicube::samples

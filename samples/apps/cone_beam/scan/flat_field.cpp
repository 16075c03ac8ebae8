#include "cone_beam/scan/scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gicube/scene/error.h"

namespace gicube::samples {
namespace {

// Of what is left of the light, the least that can be measured.
double least_of(const Stack& views, double light) { return views.counts ? 0.5 : 1e-6 * light; }  // chosen

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

// Dead pixels side by side, and the live ones at both ends of them.
struct Gap {
  std::size_t dead = 1;
  std::vector<std::size_t> ends;
};

// In the row or the column of a dead pixel, whichever has the shorter gap.
Gap gap_at(const std::vector<double>& light, std::size_t pixel, std::size_t columns) {
  const auto along = [&](std::size_t place, std::size_t count, std::size_t stride) {
    Gap gap;
    const auto take = [&](std::size_t i) {
      light[i] > 0 ? gap.ends.push_back(i) : void(++gap.dead);
      return light[i] > 0;
    };
    for (std::size_t k = 1; k <= place && !take(pixel - k * stride);) ++k;
    for (std::size_t k = 1; k < count - place && !take(pixel + k * stride);) ++k;
    return gap;
  };
  Gap row = along(pixel % columns, columns, 1), column = along(pixel / columns, light.size() / columns, columns);
  return row.ends.empty() || (!column.ends.empty() && column.dead < row.dead) ? column : row;
}

// Takes the light of pixels that got none in any view, where they make small gaps in the flat field; how many.
std::size_t take_unlit(const Stack& views, const std::vector<double>& dark, std::vector<double>& light) {
  constexpr std::size_t kLeastViews = 8,
                        kWidestGap = 4;  // chosen: an object that lets nothing through is wider in some view
  if (views.views() < kLeastViews) return 0;
  std::vector<double> sums(light.size()), lit = light;
  for (std::size_t i = 0; i < views.values.size(); ++i) sums[i % sums.size()] += static_cast<double>(views.values[i]);
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (sums[i] / static_cast<double>(views.views()) - dark[i] < least_of(views, light[i])) lit[i] = 0;
  }
  std::size_t found = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (lit[i] > 0 || light[i] <= 0) continue;
    const Gap gap = gap_at(lit, i, static_cast<std::size_t>(views.columns));
    if (gap.ends.empty() || gap.dead > kWidestGap) continue;
    light[i] = 0;
    ++found;
  }
  return found;
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
  report.unlit = take_unlit(views, dark, light);
  for (std::size_t view = 0; view < views.views(); ++view) {
    float* const values = views.values.data() + view * light.size();
    for (std::size_t i = 0; i < light.size(); ++i) {
      if (light[i] <= 0) continue;
      const double least = least_of(views, light[i]);
      const double left = static_cast<double>(values[i]) - dark[i];
      if (left < least) ++report.absorbed;
      values[i] = static_cast<float>(-std::log(std::max(left, least) / light[i]));
    }
    for (std::size_t i = 0; report.dead + report.unlit > 0 && i < light.size(); ++i) {
      if (light[i] > 0) continue;
      const Gap gap = gap_at(light, i, static_cast<std::size_t>(views.columns));
      values[i] = 0;
      for (const std::size_t end : gap.ends) values[i] += values[end] / static_cast<float>(gap.ends.size());
    }
  }
  return report;
}

}  // namespace gicube::samples

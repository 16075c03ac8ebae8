#include "cone_beam/scan/scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "gicube/scene/error.h"

namespace gicube::samples {
namespace {

// Least measurable light.
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

// A gap of adjacent dead pixels, and the live ones at its ends with their weights.
struct Gap {
  std::size_t dead = 1;
  std::vector<std::size_t> ends;
  std::vector<double> shares;

  float value(const float* view) const {
    double sum = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) sum += shares[i] * double{view[ends[i]]};
    return static_cast<float>(sum);
  }
};

// The shorter of the gaps in the row and the column of a dead pixel.
Gap gap_at(const std::vector<double>& light, std::size_t pixel, std::size_t columns) {
  const auto along = [&](std::size_t place, std::size_t count, std::size_t stride) {
    Gap gap;
    const auto take = [&](std::size_t i, std::size_t away) {
      if (!(light[i] > 0)) return void(++gap.dead), false;
      gap.ends.push_back(i);
      gap.shares.push_back(1 / static_cast<double>(away));
      return true;
    };
    for (std::size_t k = 1; k <= place && !take(pixel - k * stride, k);) ++k;
    for (std::size_t k = 1; k < count - place && !take(pixel + k * stride, k);) ++k;
    double all = 0;
    for (const double share : gap.shares) all += share;
    for (double& share : gap.shares) share /= all;
    return gap;
  };
  Gap row = along(pixel % columns, columns, 1), column = along(pixel / columns, light.size() / columns, columns);
  return row.ends.empty() || (!column.ends.empty() && column.dead < row.dead) ? column : row;
}

// Clears the flat field at small gaps of pixels that have no light in any view; returns their number.
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
      values[i] = gap_at(light, i, static_cast<std::size_t>(views.columns)).value(values);
    }
  }
  return report;
}

DeadPixels repair_pixels(Stack& views, const Stack& map) {
  constexpr std::size_t kLeastViews = 8;  // chosen
  constexpr double kStuck = 0.02;         // chosen: of the change from view to view about a pixel
  DeadPixels report;
  const std::size_t size = views.view_size(), count = views.views();
  const auto columns = static_cast<std::size_t>(views.columns);
  std::vector<double> live(size, 1);
  if (!map.values.empty()) {
    const std::vector<double> named = mean(map, views, "dead", 0);
    for (std::size_t i = 0; i < size; ++i) live[i] = named[i] == 0 ? 1 : 0;
    report.named = static_cast<std::size_t>(std::ranges::count(live, 0.0));
    if (report.named == size) throw InputError("dead", "some live pixel", "none");
  }
  if (count >= kLeastViews) {
    std::vector<double> changes(size);
    for (std::size_t view = 1; view < count; ++view) {
      const float *const now = views.values.data() + view * size, *const before = now - size;
      for (std::size_t i = 0; i < size; ++i) changes[i] += std::abs(double{now[i]} - double{before[i]});
    }
    const double all = std::accumulate(changes.begin(), changes.end(), 0.0) / static_cast<double>(size);
    std::vector<double> about;
    for (std::size_t i = 0; i < size; ++i) {
      if (live[i] == 0 || changes[i] > kStuck * all) continue;
      // Three fifths of the surrounding pixels, two on each side, change at least this much. Beside two dead columns
      // two fifths are dead, and beside a convex shadow at least half do not change.
      about.clear();
      const std::size_t row = i / columns, column = i % columns;
      for (std::size_t y = row - std::min<std::size_t>(row, 2); y <= std::min(row + 2, size / columns - 1); ++y) {
        for (std::size_t x = column - std::min<std::size_t>(column, 2); x <= std::min(column + 2, columns - 1); ++x) {
          about.push_back(changes[y * columns + x]);
        }
      }
      const std::size_t least = 2 * about.size() / 5;
      std::ranges::nth_element(about, about.begin() + static_cast<std::ptrdiff_t>(least));
      if (changes[i] >= kStuck * about[least]) continue;
      live[i] = 0;
      ++report.stuck;
    }
  }
  if (report.named + report.stuck == 0) return report;
  std::vector<std::pair<std::size_t, Gap>> gaps;
  for (std::size_t i = 0; i < size; ++i) {
    if (live[i] == 0) gaps.emplace_back(i, gap_at(live, i, columns));
  }
  for (std::size_t view = 0; view < count; ++view) {
    float* const values = views.values.data() + view * size;
    for (const auto& [pixel, gap] : gaps) values[pixel] = gap.value(values);
  }
  return report;
}

}  // namespace gicube::samples

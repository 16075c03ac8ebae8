#include "compose/ray_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gicube::samples {
namespace {

constexpr double kNothing = 1e-9;  // chosen: part of a distance; rounding causes shorter pieces

}  // namespace

void plan_ray(std::span<const Span> spans, std::span<const SurfacePoint> surfaces, double overlap_step, RayPlan& plan) {
  plan.segments.clear(), plan.layers.clear();
  const auto last = std::ranges::find_if(surfaces, [](const auto& each) { return each.look.opacity >= 1; });
  const bool opaque = last != surfaces.end();
  const double end = opaque ? last->distance : std::numeric_limits<double>::infinity();
  surfaces = surfaces.first(static_cast<std::size_t>(last - surfaces.begin()) + (opaque ? 1 : 0));

  std::vector<double> cuts;
  for (const Span& span : spans) {
    if (span.near >= end) continue;
    cuts.insert(cuts.end(), {span.near, std::min(span.far, end)});
  }
  for (const SurfacePoint& surface : surfaces) cuts.push_back(surface.distance);
  std::ranges::sort(cuts);

  auto surface = surfaces.begin();
  std::vector<const Span*> here;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    for (; surface != surfaces.end() && surface->distance <= cuts[i]; ++surface) {
      plan.layers.push_back({0, surface->look});
    }
    if (i + 1 == cuts.size() || cuts[i + 1] - cuts[i] <= kNothing * cuts[i + 1]) continue;
    const double begin = cuts[i], way = cuts[i + 1] - begin;
    here.clear();
    double voxels = 0;
    for (const Span& span : spans) {
      if (span.near > begin || span.far < cuts[i + 1]) continue;
      here.push_back(&span);
      voxels = std::max(voxels, way * length(span.direction));
    }
    if (here.empty()) continue;
    const double pieces = here.size() > 1 ? std::max(1.0, std::ceil(voxels / overlap_step)) : 1;
    for (double piece = 0; piece < pieces; ++piece) {
      const double near = begin + way * piece / pieces, far = begin + way * (piece + 1) / pieces;
      for (const Span* span : here) plan.segments.push_back({span->volume, span->at(near), span->at(far), span->shade});
      plan.layers.push_back({here.size(), {}});
    }
  }
}

Premultiplied mixed(std::span<const Premultiplied> media) {
  if (media.size() == 1) return media.front();
  const bool opaque = std::ranges::any_of(media, [](const auto& each) { return each.opacity >= 1; });
  Premultiplied sum;
  double through = 1, depths = 0;
  for (const Premultiplied& each : media) {
    // For small opacities, depth and opacity are equal.
    const double depth = opaque ? (each.opacity >= 1 ? 1 : 0) : -std::log1p(-each.opacity);
    const double share = each.opacity > 0 ? depth / each.opacity : 0;
    through *= 1 - each.opacity;
    depths += depth;
    for (std::size_t c = 0; c < 3; ++c) sum.colour[c] += share * each.colour[c];
  }
  sum.opacity = 1 - through;
  for (double& part : sum.colour) part *= depths > 0 ? sum.opacity / depths : 0;
  return sum;
}

Premultiplied over(const Premultiplied& front, const Premultiplied& behind) {
  const double seen = 1 - front.opacity;
  Premultiplied sum = front;
  sum.opacity += seen * behind.opacity;
  for (std::size_t c = 0; c < 3; ++c) sum.colour[c] += seen * behind.colour[c];
  return sum;
}

}  // namespace gicube::samples

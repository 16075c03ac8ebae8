#include <algorithm>
#include <cmath>
#include <cstdint>

#include "cone_beam/fdk.h"
#include "gicube/parallel_for.h"
#include "scene/names.h"

namespace gicube::samples {

Reconstruction backproject_into_irradiance(Board& board, const Projector& projector, const FdkSettings& settings,
                                           const ViewDensities& filtered, const Progress& progress) {
  const int bits = board.info().wide ? 32 : 11;
  const double full = std::ldexp(1, settings.bits == 0 ? bits : std::min(bits, settings.bits)) - 1;
  const auto& [dims, edge, columns, rows, poses, step] = projector.setup();
  Reconstruction out;
  out.values.resize(voxel_count(dims));
  double kept = 0, clipped = 0;
  // One pass: adds the values of one sign of these views, from `first` on.
  const auto pass = [&](std::size_t first, const std::vector<std::vector<double>>& views, double sign) {
    double most = 0, of_all = 0;
    for (std::size_t view = 0; view < views.size(); ++view) {
      double here = 0;
      for (const double value : views[view]) here = std::max(here, sign * value);
      most = std::max(most, here);
      of_all += here * projector.max_of_a_voxel(first + view);
    }
    if (most == 0) return;
    // Greatest words, and the greatest deposit of a step, which has 11 bits on any board.
    constexpr double kMaxUnits = 2047;
    const double of_a_step = most * std::max({edge.x, edge.y, edge.z}) * step / kMaxUnits;
    const double of_words = settings.headroom * of_all / full;
    board.clear_irradiance(std::max(of_a_step, of_words));
    std::vector<Ticket> tickets;
    for (std::size_t view = 0; view < views.size(); ++view) {
      std::vector<HostRay> rays = projector.rays(first + view);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        rays[i].energy = sign * views[view][i];
        rays[i].id = static_cast<std::uint32_t>(i);
      }
      std::erase_if(rays, [](const HostRay& ray) { return ray.length <= 0 || ray.energy <= 0; });
      out.rays += rays.size();
      tickets.push_back(
          board.submit(rays, {.type = RayType::kBackproject, .words = SumWords::kIrradiance, .step = step}));
    }
    for (const Ticket ticket : tickets) {
      const BatchReport report = board.receive(ticket);
      out.deposits += report.deposits->samples;
      kept += report.deposits->kept;
      clipped += report.deposits->clipped;
    }
    const std::vector<float> words = board.read_irradiance();
    for (std::size_t i = 0; i < words.size(); ++i) out.values[i] += static_cast<float>(sign) * words[i];
  };
  const std::size_t views = poses.size(), every = static_cast<std::size_t>(settings.read_every);
  for (std::size_t first = 0; first < views; first += every) {
    if (progress) progress(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(views));
    std::vector<std::vector<double>> some(std::min(views - first, every));
    parallel_for(some.size(), 0, [&](std::size_t i) { some[i] = filtered(first + i); });
    for (const double sign : {1.0, -1.0}) pass(first, some, sign);
  }
  make_up_for_faces(out.values, dims);
  out.clipped = clipped == 0 ? 0 : clipped / (kept + clipped);
  return out;
}

}  // namespace gicube::samples

#include "cone_beam/irradiance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "cone_beam/backprojector.h"
#include "cone_beam/parallel_for.h"
#include "cone_beam/view_rays.h"

namespace gicube::samples {
namespace {

class Passes {
 public:
  Passes(Board& board, const ConeGeometry& geometry, const FdkSettings& settings)
      : board_(board), geometry_(geometry), settings_(settings) {
    const int bits = board.info().wide ? 32 : 11;
    full_ = std::ldexp(1, settings.bits == 0 ? bits : std::min(bits, settings.bits)) - 1;
    out_.values.resize(voxel_count(geometry.volume.dims));
  }

  // What these views, from `first` on, leave of one sign.
  void run(std::size_t first, const std::vector<std::vector<double>>& views, double sign) {
    double most = 0, of_all = 0;
    for (const auto& view : views) {
      double here = 0;
      for (const double value : view) here = std::max(here, sign * value);
      most = std::max(most, here);
      of_all += here;
    }
    if (most == 0) return;
    // Full words, and what a step may leave at once, which has 11 bits on any board.
    constexpr double kMaxUnits = 2047;
    const Vec3 edge = geometry_.volume.spacing;
    const double of_a_step = most * std::max({edge.x, edge.y, edge.z}) * settings_.step / kMaxUnits;
    const double of_words = settings_.headroom * of_all * max_of_a_voxel(geometry_, settings_.rays) / full_;
    board_.clear_irradiance(std::max(of_a_step, of_words));
    std::vector<Ticket> tickets;
    for (std::size_t i = 0; i < views.size(); ++i) tickets.push_back(send(geometry_.angles[first + i], views[i], sign));
    for (const Ticket ticket : tickets) {
      const BatchReport report = board_.receive(ticket);
      out_.deposits += report.deposits->samples;
      kept_ += report.deposits->kept;
      clipped_ += report.deposits->clipped;
    }
    const std::vector<float> words = board_.read_irradiance();
    const auto factor = static_cast<float>(sign);
    for (std::size_t i = 0; i < words.size(); ++i) out_.values[i] += factor * words[i];
  }

  Reconstruction finish() {
    make_up_for_faces(out_.values, geometry_.volume.dims);
    out_.clipped = clipped_ == 0 ? 0 : clipped_ / (kept_ + clipped_);
    return std::move(out_);
  }

 private:
  Ticket send(double angle, const std::vector<double>& densities, double sign) {
    std::vector<HostRay> rays = view_rays(geometry_, angle, settings_.rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      rays[i].energy = sign * densities[i];
      rays[i].id = static_cast<std::uint32_t>(i);
    }
    std::erase_if(rays, [](const HostRay& ray) { return ray.length <= 0 || ray.energy <= 0; });
    out_.rays += rays.size();
    return board_.submit(rays, {.type = RayType::kBackproject, .words = SumWords::kIrradiance, .step = settings_.step});
  }

  Board& board_;
  const ConeGeometry& geometry_;
  const FdkSettings& settings_;
  double full_ = 0;
  double kept_ = 0, clipped_ = 0;
  Reconstruction out_;
};

}  // namespace

Reconstruction backproject_into_irradiance(Board& board, const ConeGeometry& geometry, const FdkSettings& settings,
                                           const FilteredView& filtered, const Progress& progress) {
  Passes passes(board, geometry, settings);
  const std::size_t views = geometry.angles.size();
  for (std::size_t first = 0; first < views; first += static_cast<std::size_t>(settings.read_every)) {
    if (progress) progress(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(views));
    const std::size_t count = std::min(views - first, static_cast<std::size_t>(settings.read_every));
    std::vector<std::vector<double>> of(count);
    parallel_for(count, [&](std::size_t i) { of[i] = filtered(first + i); });
    for (const double sign : {1.0, -1.0}) passes.run(first, of, sign);
  }
  return passes.finish();
}

}  // namespace gicube::samples

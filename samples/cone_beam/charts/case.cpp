#include "cone_beam/charts/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <numeric>
#include <utility>

#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

Projections projections_of(const Case& what) {
  Projections out = project(what.phantom, what.geometry);
  if (what.photons > 0) add_poisson_noise(out, what.photons, 1);
  return out;
}

Reconstruction made_of(Board& board, const Case& what, const Projections& projections) {
  if (const auto* fdk = std::get_if<FdkSettings>(&what.method)) {
    return reconstruct_fdk(board, what.geometry, projections, *fdk);
  }
  return reconstruct_algebraic(board, what.geometry, projections, std::get<AlgebraicSettings>(what.method));
}

// A few views around the turn; of an iterative method, so many passes through them. The same for all points whose views cost the
// same: number of views, noise and how often words are read don't matter.
Case a_part_of(const Case& what, int views, int passes) {
  constexpr double kFirst = 0.3;  // radians; not along an axis, where rays meet voxels alike
  Case part = what;
  part.geometry.angles = even_angles(views, kFirst, 2 * std::numbers::pi);
  part.photons = 0;
  if (auto* fdk = std::get_if<FdkSettings>(&part.method)) fdk->read_every = FdkSettings{}.read_every;
  if (auto* algebraic = std::get_if<AlgebraicSettings>(&part.method)) {
    *algebraic = {.method = Method::kSirt, .iterations = passes, .relaxation = 0.5, .step = algebraic->step};
  }
  return part;
}

// Parts with the same one cost the same.
std::string key_of(const Case& what) {
  const auto& g = what.geometry;
  const Detector& d = g.detector;
  const Projections projections = projections_of(what);  // of the phantom, which has no name
  std::string key = fmt::format("{:a} {} {} {} {} {} {} {} {} {}",
                                std::accumulate(projections.values.begin(), projections.values.end(), 0.0),
                                g.source_to_axis, g.source_to_detector, d.columns, d.rows, d.pitch_u, d.pitch_v,
                                g.volume.dims[0], g.volume.dims[2], g.volume.spacing.x);
  if (const auto* fdk = std::get_if<FdkSettings>(&what.method)) {
    key += fmt::format(" fdk {} {} {} {} {} {}", fdk->rays, fdk->step, static_cast<int>(fdk->accumulator),
                       fdk->normalise, fdk->bits, fdk->headroom);
  } else {
    key += fmt::format(" algebraic {}", std::get<AlgebraicSettings>(what.method).step);
  }
  return fmt::format("{} {}", key, fmt::join(what.settings, " "));
}

}  // namespace

Board Runner::open(const std::string& fidelity, const std::vector<std::string>& settings) const {
  BoardOptions options = board_;
  options.fidelity = fidelity;
  options.settings.insert(options.settings.end(), settings.begin(), settings.end());
  return Board::open(board_uri(options));
}

double Runner::rays_over_bus_ms(const Case& what) {
  const auto [known, is_new] = known_.try_emplace(key_of(a_part_of(what, 2, 1)), 0.0);
  if (!is_new) return known->second;
  const auto time = [&](const Case& part, const char* fidelity) {
    const Projections projections = projections_of(part);
    Board board = open(fidelity, part.settings);
    return to_ms(made_of(board, part, projections).board_time);
  };
  const bool filtered = std::holds_alternative<FdkSettings>(what.method);
  const Case less = a_part_of(what, 2, 1), more = a_part_of(what, filtered ? 4 : 2, 2);
  double over = 0;
  for (const auto& [fidelity, sign] : {std::pair{"cycle", 1.0}, {"functional", -1.0}}) {
    over += sign * (time(more, fidelity) - time(less, fidelity)) / 2;
  }
  return known->second = std::max(0.0, over);
}

Reconstruction Runner::reconstruct(const Case& what) {
  Board board = open("functional", what.settings);
  return made_of(board, what, projections_of(what));
}

Outcome Runner::run(const Case& what) {
  Outcome out;
  const Projections projections = projections_of(what);
  {
    Board board = open("functional", what.settings);
    const Counters before = board.counters();
    out.made = made_of(board, what, projections);
    out.bus_ms = bus_ms(board.counters() - before);
  }
  double over = rays_over_bus_ms(what);
  if (!std::holds_alternative<FdkSettings>(what.method)) {  // and once the splatted weights
    Case weights = what;
    weights.method = FdkSettings{.step = std::get<AlgebraicSettings>(what.method).step};
    over = over * static_cast<double>(out.made.residuals.size()) + rays_over_bus_ms(weights);
  }
  out.board_ms = to_ms(out.made.board_time) + static_cast<double>(what.geometry.angles.size()) * over;
  const std::vector<float> truth = voxels(what.phantom, what.geometry.volume);
  out.error = compare(what.geometry.volume, out.made.values, truth, what.field);
  return out;
}

}  // namespace gicube::samples

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "form_factors/program/options.h"
#include "scene/common/whole_file.h"
#include "scene/program/board_run.h"
#include "scene/program/program.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

constexpr double kHidden = 1e-3;

nlohmann::ordered_json statistics_of(const Visibility& seen, const VisibilityOptions& options, const BoardInfo& board) {
  const double seconds = to_ms(seen.duration) * 1e-3;
  const auto rays = static_cast<double>(seen.rays);
  return {
      {"pairs", seen.pairs},
      {"clear_pairs", seen.clear_pairs},
      {"rays", seen.rays},
      {"made", name_of(options.made)},
      {"transmittance", seen.transmittance},
      {"standard_error", seen.standard_error},
      {"hidden", seen.hidden},
      {"board_ms", to_ms(seen.duration)},
      {"bus_ms", bus_ms(seen.counters)},
      {"rays_per_simulated_second", seconds > 0 ? nlohmann::ordered_json(rays / seconds) : nlohmann::ordered_json()},
      {"host_seconds", seen.host_seconds},
      {"rays_per_host_second", rays / seen.host_seconds},
      {"utilisation", to_json(seen.utilisation)},
      {"seed", options.board.seed},
      {"board", to_json(board)},
      {"counters", to_json(seen.counters)},
      {"fidelity_report", fidelity_json(seen.counters)}};
}

void print(const Visibility& seen) {
  fmt::print("{} pairs, {} of them clear by the empty flags, {} hidden; transmittance {:.5f} +- {:.5f}\n", seen.pairs,
             seen.clear_pairs, seen.hidden, seen.transmittance, seen.standard_error);
  const double ms = to_ms(seen.duration);
  fmt::print("{} rays: {:.3f} ms simulated ({:.2f} M a second), {:.2f} s ({:.2f} M a second)\n", seen.rays, ms,
             ms > 0 ? static_cast<double>(seen.rays) / ms * 1e-3 : 0, seen.host_seconds,
             static_cast<double>(seen.rays) / seen.host_seconds * 1e-6);
  const Utilisation& u = seen.utilisation;
  fmt::print("busy: bus {:.0f}% down, {:.0f}% up, DSP {:.0f}%", 100 * u.bus_down, 100 * u.bus_up, 100 * u.dsp);
  for (const auto& [name, share] : {std::pair{"sorter", u.sorter}, {"pipelines", u.pipelines}, {"memory", u.memory}}) {
    if (share) fmt::print(", {} {:.0f}%", name, 100 * *share);
  }
  fmt::print(": bound by the {}\n", u.bound());
}

// Writes both boxes' corners in voxels, and the transmittance.
void write_pairs(const RandomPairs& pairs, const Visibility& seen, const std::filesystem::path& file) {
  std::string text =
      "a_low_x,a_low_y,a_low_z,a_high_x,a_high_y,a_high_z,b_low_x,b_low_y,b_low_z,b_high_x,b_high_y,b_high_z,"
      "transmittance\n";
  for (std::size_t i = 0; i < pairs.pairs.size(); ++i) {
    for (const std::uint32_t box : {pairs.pairs[i].a, pairs.pairs[i].b}) {
      const Element& e = pairs.elements[box];
      const Vec3 low = e.origin, high = low + e.u + e.v + e.w;
      text += fmt::format("{},{},{},{},{},{},", low.x, low.y, low.z, high.x, high.y, high.z);
    }
    text += fmt::format("{}\n", seen.transmittances[i]);
  }
  write_whole(file, text);
}

}  // namespace

RandomPairs random_pairs(const Dims& dims, std::uint32_t count, std::uint64_t seed) {
  std::mt19937_64 engine(seed);  // its numbers are portable; those of distributions are not
  RandomPairs out;
  std::array<int, 3> last{-1, -1, -1};
  while (out.pairs.size() < count) {
    std::array<int, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell[axis] = static_cast<int>((engine() >> 32) * static_cast<std::uint64_t>(dims[axis]) >> 32);
    }
    if (out.elements.size() % 2 == 1 && cell == last) continue;
    std::array<double, 3> low{}, edge{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::max(0.0, cell[axis] - 0.5);
      edge[axis] = std::min(dims[axis] - 1.0, cell[axis] + 0.5) - low[axis];
    }
    out.elements.push_back(
        {ElementKind::kBox, {low[0], low[1], low[2]}, {edge[0], 0, 0}, {0, edge[1], 0}, {0, 0, edge[2]}});
    last = cell;
    const auto at = static_cast<std::uint32_t>(out.elements.size());
    if (at % 2 == 0) out.pairs.push_back({at - 2, at - 1, at / 2 - 1});
  }
  return out;
}

Visibility look(Board& board, const RandomPairs& pairs, const PairRequest& request, const Progress& progress) {
  RunWindow window(board);
  const std::vector<PairFactor> factors = board.pair_factors(pairs.elements, pairs.pairs, request, progress);
  Visibility out;
  out.duration = window.simulated();
  out.host_seconds = window.host_seconds();
  out.counters = window.counters();
  out.utilisation = utilisation_of(out.counters, out.duration, board.info());
  out.pairs = factors.size();
  out.rays = std::uint64_t{factors.size()} * request.rays;
  double sum = 0, squares = 0;
  for (const PairFactor& factor : factors) {
    const double through = factor.geometric > 0 ? factor.transported / factor.geometric : 0;
    out.transmittances.push_back(through);
    sum += through;
    squares += through * through;
    out.clear_pairs += factor.clear ? 1 : 0;
    out.hidden += through < kHidden ? 1 : 0;
  }
  const auto n = static_cast<double>(std::max<std::size_t>(factors.size(), 2));
  out.transmittance = sum / n;
  out.standard_error = std::sqrt(std::max(0.0, squares / n - out.transmittance * out.transmittance) / (n - 1));
  return out;
}

void run(const VisibilityOptions& options, ProgressLine& progress) {
  check_outputs({{"--stats", options.board.stats}, {"--pairs-file", options.pairs_file}});
  progress.show("reading the scene");
  const SceneSetup setup = set_up(scene_of(options.input), options.board.threads);
  Board board = open_board(options.board);
  check_renders(setup.volume.dims, board.info(), setup.volume.source);
  load(board, setup, false, progress.parts("loading the volume"));
  const RandomPairs pairs = random_pairs(setup.volume.dims, options.pairs, options.board.seed);
  const PairRequest request{.rays = static_cast<std::uint32_t>(options.rays),
                            .seed = static_cast<std::uint32_t>(options.board.seed),
                            .step = options.step,
                            .made = options.made};
  const Visibility seen = look(board, pairs, request, progress.parts("looking"));
  progress.clear();
  if (!options.pairs_file.empty()) write_pairs(pairs, seen, options.pairs_file);
  if (!options.board.quiet) print(seen);
  if (!options.board.stats.empty()) {
    write_json(statistics_of(seen, options, board.info()), provenance_of(board.info(), scene_hash(setup)),
               options.board.stats);
  }
}

}  // namespace gicube::samples

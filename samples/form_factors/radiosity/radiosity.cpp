#include "form_factors/radiosity/radiosity.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

#include "form_factors/radiosity/refinement.h"
#include "scene/program/input_error.h"

namespace gicube::samples {
namespace {

constexpr int kMaxPasses = 10;  // chosen: of refining and solving; light needs a pass for each bounce that matters

void require(bool good, const char* field, const char* expected, double got) {
  if (!good) throw InputError(std::string("settings.") + field, expected, fmt::format("{}", got));
}

void check(const RadiositySettings& settings) {
  require(settings.error > 0, "error", "a number above 0", settings.error);
  require(settings.rays >= 8 && settings.rays <= 65'536, "rays", "8 to 65536", settings.rays);
  require(settings.max_rays >= settings.rays && settings.max_rays <= 1 << 24, "max_rays", "rays to 2^24",
          settings.max_rays);
  require(settings.step >= 1.0 / 64 && settings.step <= 16, "step", "1/64 to 16", settings.step);
  require(settings.convergence > 0, "convergence", "a number above 0", settings.convergence);
  require(settings.max_iterations > 0, "max_iterations", "1 or more", settings.max_iterations);
  require(settings.leaf_voxels > 0 && std::has_single_bit(static_cast<unsigned>(settings.leaf_voxels)), "leaf_voxels",
          "a power of two", settings.leaf_voxels);
}

void check(const Emissions& emissions) {
  for (std::size_t tag = 0; tag < emissions.size(); ++tag) {
    for (const double power : emissions[tag].power) {
      if (power >= 0 && std::isfinite(power)) continue;
      throw InputError(fmt::format("emissions[{}].power", tag), "numbers from 0", fmt::format("{}", power));
    }
  }
}

}  // namespace

std::array<int, 3> voxel_behind(const Leaf& leaf) {
  std::array<int, 3> voxel = leaf.cell;
  if (leaf.facing < kMedium) voxel[leaf.facing / 2u] += leaf.facing % 2 == 0 ? 1 : -1;
  return voxel;
}

RadiosityResult solve_radiosity(Board& board, const SceneSetup& setup, const Emissions& emissions,
                                const RadiositySettings& settings, const RadiosityProgress& progress) {
  const auto start = std::chrono::steady_clock::now();
  check(settings);
  check(emissions);
  const Medium medium = make_medium(setup, settings.solid_opacity);
  const Forest forest = make_forest(make_leaves(medium, setup, emissions), medium.edges, settings.leaf_voxels);
  RadiositySolver solver(forest);
  if (!(solver.emitted()[0] + solver.emitted()[1] + solver.emitted()[2] > 0)) {
    throw InputError("emissions", "some power from an open face or medium", "none");
  }
  load(board, medium, settings.step);

  RadiosityResult result;
  RadiosityStatistics& statistics = result.statistics;
  const Counters before = board.counters();
  const Picoseconds begin = board.now();
  const Contents contents(medium);
  LinkSampler sampler(board, forest, contents, settings, statistics);
  LinkSet links(forest, sampler, settings, statistics, progress);
  // Early passes need not be exact: each bounce of light shows where the next ones matter.
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const bool refined = links.refine(solver, settings.error);
    if (!refined && pass > 0) break;
    result.links = links.links();
    // Sums of early links may be so much too large that light would grow.
    solver.solve(result.links, settings, true, statistics.iterations);
    if (progress) progress("passes", static_cast<double>(pass + 1) / kMaxPasses);
  }
  if (!settings.balance) solver.solve(result.links, settings, false, statistics.iterations);
  solver.results(result);

  const Counters window = board.counters() - before;
  statistics.bus_down_bytes = window.value("bus.down.bytes");
  statistics.bus_up_bytes = window.value("bus.up.bytes");
  statistics.board_time = board.now() - begin;
  for (const Leaf& leaf : forest.leaves) {
    ++(leaf.tag == kOutside ? statistics.ends : leaf.facing == kMedium ? statistics.medium : statistics.faces);
  }
  statistics.clusters = forest.clusters.size();
  statistics.links = result.links.size();
  result.leaves = forest.leaves;
  result.clusters = forest.clusters;
  statistics.host_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace gicube::samples

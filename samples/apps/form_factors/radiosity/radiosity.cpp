#include "form_factors/radiosity/radiosity.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <map>

#include "form_factors/exchange/sampler.h"
#include "form_factors/radiosity/solver.h"
#include "scene/common/checks.h"

namespace gicube::samples {
namespace {

constexpr int kMaxPasses = 10;  // chosen: passes of refining and solving; each important bounce of light needs one

void check(const RadiositySettings& settings) {
  require(settings.error > 0, "settings.error", "a number above 0", settings.error);
  require(settings.rays >= 8 && settings.rays <= 65'536, "settings.rays", "8 to 65536", settings.rays);
  require(settings.max_rays >= settings.rays && settings.max_rays <= 1 << 24, "settings.max_rays", "rays to 2^24",
          settings.max_rays);
  require(settings.step >= 1.0 / 64 && settings.step <= 16, "settings.step", "1/64 to 16", settings.step);
  require(settings.convergence > 0, "settings.convergence", "a number above 0", settings.convergence);
  require(settings.max_iterations > 0, "settings.max_iterations", "1 or more", settings.max_iterations);
  require(settings.leaf_voxels > 0 && std::has_single_bit(static_cast<unsigned>(settings.leaf_voxels)),
          "settings.leaf_voxels", "a power of two", settings.leaf_voxels);
}

void check(const Emissions& emissions) {
  for (std::size_t tag = 0; tag < emissions.size(); ++tag) {
    for (const auto& [name, powers] :
         {std::pair{"surface", emissions[tag].surface}, {"volume", emissions[tag].volume}}) {
      for (const double power : powers) {
        if (power >= 0 && std::isfinite(power)) continue;
        throw InputError(fmt::format("emissions[{}].{}", tag, name), "numbers from 0", fmt::format("{}", power));
      }
    }
  }
}

double extent(const Cluster& cluster) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    square += (cluster.high[axis] - cluster.low[axis]) * (cluster.high[axis] - cluster.low[axis]);
  }
  return square;
}

// Greatest share over channels of the emitted power that an error `of` an exchange area misplaces.
double misplaced(const RadiositySolver& solver, const Link& link, double of) {
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double emitted = solver.emitted()[c];
    if (emitted > 0) most = std::max(most, std::max(solver.outgoing(link.a)[c], solver.outgoing(link.b)[c]) / emitted);
  }
  return of * most;
}

constexpr double kNearRays = 64;  // chosen
constexpr double kNoise = 0.25;   // chosen: part of the error that may come from too few rays: that of 16 of them

// Links of the hierarchy, refined where they may misplace much power, or of all pairs of leaves.
class LinkSet {
 public:
  // Starts with links of all roots, or of all leaves' clusters, each with a first estimate.
  LinkSet(const Forest& forest, LinkSampler& sampler, const RadiositySettings& settings,
          RadiosityStatistics& statistics, const RadiosityProgress& progress)
      : clusters_(forest.clusters),
        sampler_(sampler),
        settings_(settings),
        statistics_(statistics),
        progress_(progress) {
    std::vector<std::uint32_t> ends;
    std::array<std::uint64_t, 7> count{};
    for (std::uint32_t i = 0; i < clusters_.size(); ++i) {
      if (clusters_[i].child != kNone) continue;
      ends.push_back(i);
      ++count[clusters_[i].facing];
    }
    for (std::size_t a = 0; a < 7; ++a) {
      for (std::size_t b = a + 1; b < 7; ++b) statistics.all_pairs += count[a] * count[b];
    }
    statistics.all_pairs += count[kMedium] * (count[kMedium] + 1) / 2;

    const std::vector<std::uint32_t>& first = settings.hierarchy ? forest.roots : ends;
    for (std::size_t i = 0; i < first.size(); ++i) {
      for (std::size_t j = i; j < first.size(); ++j) add(first[i], first[j], links_);
    }
    guess(links_);
  }

  // Divides the links that may misplace more than `error` of the emitted power with the solver's radiosities, and
  // measures the others, more exactly those that cannot be divided. False if no link changed.
  bool refine(const RadiositySolver& solver, double error) {
    std::vector<SampledLink> kept, fresh, next;
    const auto sort_out = [&](const std::vector<SampledLink>& links) {
      next.clear();
      for (const SampledLink& sampled : links) {
        if (divisible(sampled.link) && misplaced(solver, sampled.link, sampled.first_spread) > error) {
          divide(sampled.link, next);
          ++statistics_.refinements;
        } else {
          kept.push_back(sampled);
        }
      }
    };
    sort_out(links_);
    const bool any = !next.empty();
    while (!next.empty()) {
      fresh.swap(next);
      guess(fresh);
      sort_out(fresh);
    }
    links_.swap(kept);
    return measure(solver, error) || any;
  }

  std::vector<Link> links() const {
    std::vector<Link> out;
    for (const SampledLink& sampled : links_) out.push_back(sampled.link);
    return out;
  }

 private:
  bool divisible(const Link& link) const {
    return clusters_[link.a].child != kNone || clusters_[link.b].child != kNone;
  }

  void add(std::uint32_t a, std::uint32_t b, std::vector<SampledLink>& to) const {
    if (may_see(clusters_[a], clusters_[b])) to.push_back({{.a = a, .b = b}});
  }

  void divide(const Link& link, std::vector<SampledLink>& to) const {
    const Cluster& a = clusters_[link.a];
    const Cluster& b = clusters_[link.b];
    if (link.a == link.b) {
      for (std::uint32_t i = 0; i < a.children; ++i) {
        for (std::uint32_t j = i; j < a.children; ++j) add(a.child + i, a.child + j, to);
      }
    } else if (b.child == kNone || (a.child != kNone && extent(a) >= extent(b))) {
      for (std::uint32_t i = 0; i < a.children; ++i) add(a.child + i, link.b, to);
    } else {
      for (std::uint32_t i = 0; i < b.children; ++i) add(link.a, b.child + i, to);
    }
  }

  void guess(std::vector<SampledLink>& links) {
    constexpr std::size_t kAtOnce = 1u << 16;
    for (std::size_t begin = 0; begin < links.size(); begin += kAtOnce) {
      const std::size_t end = std::min(begin + kAtOnce, links.size());
      std::vector<SampledLink*> part;
      for (std::size_t i = begin; i < end; ++i) part.push_back(&links[i]);
      sampler_.estimate(part, settings_.rays);
      for (SampledLink* sampled : part) {
        sampled->first_error = sampled->link.standard_error;
        sampled->first_spread = sampled->link.spread;
      }
      if (progress_) progress_("links", static_cast<double>(end) / static_cast<double>(links.size()));
    }
  }

  // Number of rays for an estimate; 0 keeps its first estimate.
  std::uint32_t rays_for(const SampledLink& sampled, const RadiositySolver& solver, double error) const {
    const Link& link = sampled.link;
    if (link.rays == 0) return 0;  // exact
    if (divisible(link)) return static_cast<std::uint32_t>(settings_.rays);
    const double off = misplaced(solver, link, sampled.first_error) / (kNoise * error);
    double rays = off > 1 ? settings_.rays * off * off : 0;
    // Touching clusters with an obstacle: few rays sample too little of their nearest parts.
    if (sampler_.place_of(clusters_[link.a], clusters_[link.b]).near()) rays = std::max(rays, kNearRays);
    if (rays == 0) return 0;
    const double high = std::max(settings_.max_rays, settings_.rays);
    return std::bit_floor(static_cast<std::uint32_t>(std::clamp(2 * rays, double(settings_.rays), high)));
  }

  // Uses new rays. If the estimate that decides to keep a link were also its measure, low ones would be kept and high
  // ones divided, and the sum would be too low.
  bool measure(const RadiositySolver& solver, double error) {
    std::map<std::uint32_t, std::vector<SampledLink*>> wanted;
    for (SampledLink& sampled : links_) {
      const std::uint32_t rays = rays_for(sampled, solver, error);
      if (rays > (sampled.measured ? sampled.link.rays : 0)) wanted[rays].push_back(&sampled);
    }
    for (const auto& [rays, links] : wanted) {
      sampler_.estimate(links, static_cast<int>(rays));
      for (SampledLink* sampled : links) {
        sampled->link.spread = std::max(sampled->link.spread, sampled->first_spread);
        sampled->measured = true;
      }
    }
    return !wanted.empty();
  }

  const std::vector<Cluster>& clusters_;
  LinkSampler& sampler_;
  const RadiositySettings& settings_;
  RadiosityStatistics& statistics_;
  const RadiosityProgress& progress_;
  std::vector<SampledLink> links_;
};

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
  if (!(total(solver.emitted()) > 0)) {
    throw InputError("emissions", "some power from an open face or medium", "none");
  }
  load(board, medium);

  RadiosityResult result;
  RadiosityStatistics& statistics = result.statistics;
  const Counters before = board.counters();
  const Picoseconds begin = board.now();
  const Contents contents(medium);
  LinkSampler sampler(board, forest, contents, settings, statistics);
  LinkSet links(forest, sampler, settings, statistics, progress);
  // Early passes need not be exact: each bounce of light shows the important next ones.
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    const bool refined = links.refine(solver, settings.error);
    if (!refined && pass > 0) break;
    result.links = links.links();
    // Sums of early links may be so large that light would grow.
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

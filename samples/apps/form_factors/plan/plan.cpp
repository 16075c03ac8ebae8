#include "form_factors/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "gicube/scene/error.h"

namespace gicube::samples {
namespace {

constexpr double kFirst = 1e-2, kLast = 1e-7;  // chosen: thresholds
constexpr double kStep = 3.1622776601683795;   // chosen: from one to the next; rays then grow about twofold
constexpr double kGain = 0.85;                 // chosen: of error^2 x rays, what makes a variant worth taking
constexpr double kTimeMargin = 1.25;           // as of pictures

// chosen: error of the later of two solutions over their difference. If each solution has 3/4 of the error of the one
// before, it is 0.6 for independent errors, and 3 for equal ones (docs/guide/plan.md has the measurements). In both
// cases the earlier one has a third more error.
constexpr double kEstimate = 1, kBound = 2, kOfEarlier = 4.0 / 3;

struct Solution {
  RadiosityResult result;
  std::size_t point = 0;  // of the plan
};

struct Planner {
  Board& board;
  const SceneSetup& setup;
  const Emissions& emissions;
  const RadiosityProgress& progress;
  RadiosityPlan plan;
  int first_rays = plan.settings.rays;
  std::uint32_t solutions = 0;

  std::optional<Solution> cheapest{};  // with a bound that keeps the target

  RadiosityPlan make() {
    const auto start = std::chrono::steady_clock::now();
    Solution before = solve(plan.settings);
    plan.kept = false;
    for (int stage = 1; plan.settings.error / kStep >= kLast; ++stage) {
      const RadiosityPlanPoint& last = plan.points[before.point];
      if (plan.target.time_budget > 0 && too_long(last)) break;
      plan.settings.error /= kStep;
      plan.settings.hierarchy = 2 * last.all_rays < plan.finest_rays;  // chosen: else a full matrix needs as few
      Solution here = solve(plan.settings);
      const double off = difference(before.result, here.result);
      tell(before.point, off, kOfEarlier);
      tell(here.point, off, 1);
      if (stage == 2) try_variants(here.result, before.point, off);
      const bool over = plan.target.time_budget > 0 && plan.points[here.point].time > plan.target.time_budget;
      if (over) break;
      consider(std::exchange(before, std::move(here)));
      if (keeps(before.point) || cheapest) break;
      if (!plan.settings.hierarchy) break;  // no solution is finer
    }
    if (plan.target.max_error > 0) {
      consider(before);
      plan.kept = cheapest.has_value();
      if (cheapest) before = *std::move(cheapest);
    } else {
      plan.kept = plan.points[before.point].time <= plan.target.time_budget;
    }
    const RadiosityPlanPoint& chosen = plan.chosen = plan.points[before.point];
    plan.settings.hierarchy = chosen.hierarchy;
    plan.settings.error = chosen.threshold;
    plan.settings.rays = chosen.rays;
    plan.settings.leaf_voxels = chosen.leaf_voxels;
    plan.settings.seed = chosen.seed;
    plan.result = std::move(before.result);
    const double more = chosen.all_rays > 0 ? plan.finest_rays / chosen.all_rays : 1;
    plan.finest_time = static_cast<Picoseconds>(more * static_cast<double>(chosen.time));
    plan.host_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return std::move(plan);
  }

  Solution solve(RadiositySettings settings) {
    settings.seed += solutions++;
    settings.max_rays = std::max(settings.max_rays, settings.rays);
    RadiosityResult result = solve_radiosity(board, setup, emissions, settings, progress);
    const RadiosityStatistics& statistics = result.statistics;
    plan.points.push_back({.hierarchy = settings.hierarchy,
                           .threshold = settings.error,
                           .rays = settings.rays,
                           .leaf_voxels = settings.leaf_voxels,
                           .seed = settings.seed,
                           .error = 1,
                           .error_bound = 1,  // nothing is known of it
                           .all_rays = static_cast<double>(statistics.rays),
                           .time = statistics.board_time});
    plan.all_rays += plan.points.back().all_rays;
    plan.finest_rays = static_cast<double>(statistics.all_pairs) * first_rays;
    return {std::move(result), plan.points.size() - 1};
  }

  // Sets a point's error and bound from the difference to another solution; the lower of two bounds holds.
  void tell(std::size_t index, double off, double factor) {
    RadiosityPlanPoint& point = plan.points[index];
    if (point.difference > 0 && kBound * factor * off >= point.error_bound) return;
    point.difference = off;
    point.error = kEstimate * factor * off;
    point.error_bound = kBound * factor * off;
  }

  bool keeps(std::size_t index) const {
    return plan.target.max_error > 0 && plan.points[index].error_bound <= plan.target.max_error;
  }
  void consider(Solution solution) {
    if (!keeps(solution.point)) return;
    const double rays = plan.points[solution.point].all_rays;
    if (!cheapest || rays < plan.points[cheapest->point].all_rays) cheapest = std::move(solution);
  }

  // The solutions of the stage before; they differed by `off` from this one's solution.
  void try_variants(const RadiosityResult& better, std::size_t base, double off) {
    RadiositySettings original = plan.settings;
    original.hierarchy = true;
    original.error = plan.points[base].threshold;
    double best = kGain * std::pow(off, 2) * plan.points[base].all_rays;
    // chosen: numbers of rays other than 16, and cubes twice as large
    for (const auto& [rays, times] : {std::pair{8, 1}, {32, 1}, {original.rays, 2}}) {
      RadiositySettings variant = original;
      variant.rays = rays;
      variant.leaf_voxels *= times;
      Solution solution = solve(variant);
      tell(solution.point, difference(solution.result, better), kOfEarlier);
      const RadiosityPlanPoint& point = plan.points[solution.point];
      const double merit = point.difference * point.difference * point.all_rays;
      consider(std::move(solution));
      if (merit >= best) continue;
      best = merit;
      plan.settings.rays = variant.rays;
      plan.settings.leaf_voxels = variant.leaf_voxels;
    }
  }

  // Predicts the next solution from the last two; after only one, twice as long.
  bool too_long(const RadiosityPlanPoint& point) const {
    double growth = 2;
    for (const RadiosityPlanPoint& other : plan.points) {
      if (other.threshold <= point.threshold * 1.01 || other.time == 0) continue;
      growth = std::max(1.0, static_cast<double>(point.time) / static_cast<double>(other.time));
    }
    return kTimeMargin * (growth * static_cast<double>(point.time)) > static_cast<double>(plan.target.time_budget);
  }
};

}  // namespace

std::vector<std::string> RadiosityPlan::explain() const {
  constexpr const char* kFinest = "a full matrix";
  const std::string which =
      chosen.hierarchy ? fmt::format("divided where they may misplace more than {:.2g} of all power", chosen.threshold)
                       : std::string("one for each pair of elements");
  return {plan_headline("", target, kept),
          fmt::format("links: {}, {} rays a first guess", which, chosen.rays),
          chosen.leaf_voxels > 1 ? fmt::format("subdivision: to cubes of {} voxels", chosen.leaf_voxels)
                                 : std::string("subdivision: to single voxels"),
          plan_error_line(
              chosen.error,
              fmt::format("of the light on all elements ({:.2g}% from another solution)", 100 * chosen.difference),
              chosen.error_bound),
          plan_cost_line("rays", chosen.all_rays, kFinest, finest_rays),
          plan_time_line(chosen.time, kFinest, finest_time),
          fmt::format("the plan itself: {} solutions, {} rays, {:.2f} s of the host; the chosen one is used",
                      points.size(), count_text(all_rays), host_seconds)};
}

RadiosityPlan plan_radiosity(Board& board, const SceneSetup& setup, const Emissions& emissions,
                             const RadiositySettings& settings, const PlanTarget& target,
                             const RadiosityProgress& progress) {
  if ((target.max_error > 0) == (target.time_budget > 0)) {
    throw InputError("target", "one of max_error and time_budget", target.max_error > 0 ? "both" : "none");
  }
  RadiosityPlan plan;
  plan.target = target;
  plan.settings = settings;
  plan.settings.hierarchy = true;
  plan.settings.error = kFirst;
  return Planner{board, setup, emissions, progress, plan}.make();
}

double difference(const RadiosityResult& result, const RadiosityResult& reference) {
  if (result.leaves.size() != reference.leaves.size()) {
    throw InputError("reference.leaves", fmt::format("{} as the result has", result.leaves.size()),
                     fmt::format("{}", reference.leaves.size()));
  }
  double off = 0, all = 0;
  for (std::size_t i = 0; i < result.leaves.size(); ++i) {
    const Leaf& leaf = result.leaves[i];
    if (leaf.tag == kOutside) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      off += leaf.weight * std::abs(result.incident[i][c] - reference.incident[i][c]);
      all += leaf.weight * reference.incident[i][c];
    }
  }
  return off / all;
}

}  // namespace gicube::samples

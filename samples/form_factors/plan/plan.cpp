#include "form_factors/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "scene/program/input_error.h"

namespace gicube::samples {
namespace {

constexpr double kFirst = 1e-2, kLast = 1e-7;  // chosen: thresholds
constexpr double kStep = 3.1622776601683795;   // chosen: from one to the next; rays then grow about twofold
constexpr double kGain = 0.85;                 // chosen: of error^2 x rays, what makes a variant worth taking
constexpr double kTimeMargin = 1.25;           // as of pictures

// chosen: the error of the later of two solutions over what they differ by. If their errors knew nothing of each other it would be
// 0.6, where each solution errs by three quarters of the one before; if they erred alike, 3 (docs/guide/plan.md has what was measured).
constexpr double kEstimate = 1, kBound = 2;

class Planner {
 public:
  Planner(Board& board, const SceneSetup& setup, const Emissions& emissions, const RadiositySettings& settings,
          const PlanTarget& target, const RadiosityProgress& progress)
      : board_(board), setup_(setup), emissions_(emissions), progress_(progress), first_rays_(settings.rays) {
    plan_.settings = settings;
    plan_.settings.hierarchy = true;
    plan_.settings.error = kFirst;
    plan_.target = target;
  }

  RadiosityPlan make() {
    const auto start = std::chrono::steady_clock::now();
    auto [before, point_before] = solve(plan_.settings);
    plan_.kept = false;
    for (int stage = 1; plan_.settings.error / kStep >= kLast; ++stage) {
      if (plan_.target.time_budget > 0 && too_long(point_before)) break;
      plan_.settings.error /= kStep;
      plan_.settings.hierarchy =
          2 * point_before.all_rays < plan_.finest_rays;  // chosen: else a full matrix does as well
      auto [result, point] = solve(plan_.settings);
      tell(point, difference(before, result));
      plan_.points.push_back(point);
      if (stage == 2) try_variants(result, point_before);
      const bool over = plan_.target.time_budget > 0 && point.time > plan_.target.time_budget;
      if (over) break;
      before = std::move(result);
      point_before = point;
      if (plan_.target.max_error > 0 && point.error_bound <= plan_.target.max_error) {
        plan_.kept = true;
        break;
      }
      if (!plan_.settings.hierarchy) break;  // there is nothing finer
    }
    if (plan_.target.time_budget > 0) plan_.kept = point_before.time <= plan_.target.time_budget;
    const RadiosityPlanPoint& chosen = plan_.chosen = point_before;
    plan_.settings.hierarchy = chosen.hierarchy;
    plan_.settings.error = chosen.threshold;
    plan_.settings.rays = chosen.rays;
    plan_.settings.leaf_voxels = chosen.leaf_voxels;
    plan_.settings.seed = chosen.seed;
    plan_.result = std::move(before);
    const double more = chosen.all_rays > 0 ? plan_.finest_rays / chosen.all_rays : 1;
    plan_.finest_time = static_cast<Picoseconds>(more * static_cast<double>(chosen.time));
    plan_.host_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return std::move(plan_);
  }

 private:
  std::pair<RadiosityResult, RadiosityPlanPoint> solve(RadiositySettings settings) {
    settings.seed += solutions_++;
    settings.max_rays = std::max(settings.max_rays, settings.rays);
    RadiosityResult result = solve_radiosity(board_, setup_, emissions_, settings, progress_);
    const RadiosityStatistics& statistics = result.statistics;
    RadiosityPlanPoint point{.hierarchy = settings.hierarchy,
                             .threshold = settings.error,
                             .rays = settings.rays,
                             .leaf_voxels = settings.leaf_voxels,
                             .seed = settings.seed,
                             .all_rays = static_cast<double>(statistics.rays),
                             .time = statistics.board_time};
    plan_.all_rays += point.all_rays;
    plan_.finest_rays = static_cast<double>(statistics.all_pairs) * first_rays_;
    if (plan_.points.empty()) {
      point.error = point.error_bound = 1;  // nothing is known of it
      plan_.points.push_back(point);
    }
    return {std::move(result), point};
  }

  static void tell(RadiosityPlanPoint& point, double difference) {
    point.difference = difference;
    point.error = kEstimate * difference;
    point.error_bound = kBound * difference;
  }

  // Those of the stage before, held against this one's solution as that stage's own was.
  void try_variants(const RadiosityResult& better, const RadiosityPlanPoint& base) {
    RadiositySettings original = plan_.settings;
    original.hierarchy = true;
    original.error = base.threshold;
    double best = kGain * std::pow(plan_.points.back().difference, 2) * base.all_rays;
    // chosen: rays beside 16, and cubes twice as large
    for (const auto& [rays, times] : {std::pair{8, 1}, {32, 1}, {original.rays, 2}}) {
      RadiositySettings variant = original;
      variant.rays = rays;
      variant.leaf_voxels *= times;
      auto [result, point] = solve(variant);
      tell(point, difference(result, better));
      plan_.points.push_back(point);
      const double merit = point.difference * point.difference * point.all_rays;
      if (merit >= best) continue;
      best = merit;
      plan_.settings.rays = variant.rays;
      plan_.settings.leaf_voxels = variant.leaf_voxels;
    }
  }

  // The next solution, as the last two make one expect; where there is only one, twice as long.
  bool too_long(const RadiosityPlanPoint& point) const {
    double growth = 2;
    for (const RadiosityPlanPoint& other : plan_.points) {
      if (other.threshold <= point.threshold * 1.01 || other.time == 0) continue;
      growth = std::max(1.0, static_cast<double>(point.time) / static_cast<double>(other.time));
    }
    return kTimeMargin * (growth * static_cast<double>(point.time)) > static_cast<double>(plan_.target.time_budget);
  }

  Board& board_;
  const SceneSetup& setup_;
  const Emissions& emissions_;
  const RadiosityProgress& progress_;
  const int first_rays_;
  std::uint32_t solutions_ = 0;
  RadiosityPlan plan_;
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
              fmt::format("of the light on all elements ({:.2g}% from a coarser solution)", 100 * chosen.difference),
              chosen.error_bound),
          plan_cost_line("rays", chosen.all_rays, kFinest, finest_rays),
          plan_time_line(chosen.time, kFinest, finest_time),
          fmt::format("the plan itself: {} solutions, {} rays, {:.2f} s of the host; the last is used", points.size(),
                      count_text(all_rays), host_seconds)};
}

RadiosityPlan plan_radiosity(Board& board, const SceneSetup& setup, const Emissions& emissions,
                             const RadiositySettings& settings, const PlanTarget& target,
                             const RadiosityProgress& progress) {
  if ((target.max_error > 0) == (target.time_budget > 0)) {
    throw InputError("target", "one of max_error and time_budget", target.max_error > 0 ? "both" : "none");
  }
  return Planner(board, setup, emissions, settings, target, progress).make();
}

}  // namespace gicube::samples

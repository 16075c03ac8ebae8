#include "cone_beam/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "gicube/error.h"

namespace gicube::samples {
namespace {

constexpr double kFinestStep = 0.5;
constexpr double kSteps[] = {1, 2};  // chosen
constexpr int kMaxEvery = 8;
constexpr int kMinSlices = 12, kMaxSlices = 40;  // chosen: of a pilot; an eighth of the volume between them
constexpr int kFaces = 2;                        // slices at a pilot's faces, which have no neighbours
constexpr int kTries = 12;                       // chosen
constexpr int kParts = 24;                       // of the progress
constexpr double kAgain = 1.01;  // as for pictures: greatest increase of a volume's time in the next run
// chosen: bound of other slices' errors, relative to the pilot's worst slice. A head's error is up to 1.6 times that of
// its middle (docs/guide/plan.md has the measurements).
constexpr double kMargin = 2;

struct SlabError {
  double all = 0, bound = 0;
};

// Errors relative to the whole slab's values; the bound is the worst slice's error times the margin.
SlabError error_of(const Grid& grid, const std::vector<float>& values, const std::vector<float>& best, double radius) {
  double off = 0, power = 0, worst = 0;
  int slices = 0;
  for (int z = kFaces; z < grid.dims[2] - kFaces; ++z, ++slices) {
    double slice = 0;
    std::size_t i = voxel_count({grid.dims[0], grid.dims[1], z});
    for_each_in_slice(grid, static_cast<std::size_t>(z), [&](Vec3 place) {
      const double value = double{values[i]}, wanted = double{best[i]};
      ++i;
      if (std::hypot(place.x, place.y) > radius) return;
      slice += std::pow(value - wanted, 2);
      power += std::pow(wanted, 2);
    });
    off += slice;
    worst = std::max(worst, slice);
  }
  if (!(power > 0)) return {0, std::numeric_limits<double>::infinity()};
  return {std::sqrt(off / power), kMargin * std::sqrt(worst * slices / power)};
}

FdkSettings with(const FdkPlanPoint& point, FdkSettings settings) {
  settings.rays = point.rays;
  settings.step = point.step;
  return settings;
}

struct Planner {
  Board& board;
  Board& timed;
  const ConeGeometry& geometry;
  const Projections& projections;
  const FdkSettings& asked;
  const Progress& progress;
  FdkPlan plan;
  Slab slab = slab_of(geometry, projections, std::clamp(geometry.volume.dims[2] / 8, kMinSlices, kMaxSlices));
  std::vector<float> best{};

  // Cost of a view in the whole volume, from runs of two and of six views.
  struct Costs {
    double deposits = 0, view = 0, rest = 0;  // of a view; picoseconds of a view, and of all work that is done once
  };
  std::map<std::pair<int, double>, Costs> known_costs{};  // by rays and step

  FdkPlan make() {
    const auto start = std::chrono::steady_clock::now();
    plan.views = geometry.angles.size();
    plan.slices = slab.geometry.volume.dims[2];
    plan.field = field_seen(geometry, is_displaced(geometry, projections));
    const PixelRays by_default = rays_of(asked, geometry);
    plan.finest = {1, std::min(std::max(by_default.u, by_default.v) + 1, 4), kFinestStep};
    best = pilot(plan.finest);
    predict(plan.finest);
    for (const FdkPlanPoint& one : coarser_ones()) tried(one);
    const std::vector<FdkPlanPoint> all = together(plan.points);
    plan.target.max_error > 0 ? choose_cheapest(all) : choose_within_time(all);
    plan.host_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return std::move(plan);
  }

  // Reconstructs the slab.
  std::vector<float> pilot(const FdkPlanPoint& point) {
    const std::size_t views = slab.geometry.angles.size();
    const Reconstruction made = reconstruct_fdk(board, some_views(slab.geometry, point.every),
                                                some_views(slab.projections, views, point.every), with(point, asked));
    ++plan.pilots;
    plan.pilot_deposits += static_cast<double>(made.deposits);
    if (progress) progress(static_cast<std::uint32_t>(std::min(plan.pilots, kParts - 1)), kParts);
    return made.values;
  }

  FdkPlanPoint tried(FdkPlanPoint point) {
    const SlabError error = error_of(slab.geometry.volume, pilot(point), best, plan.field.radius);
    point.error = error.all;
    point.error_bound = error.bound;
    predict(point);
    plan.points.push_back(point);
    return point;
  }

  // Settings that are coarser in one parameter.
  std::vector<FdkPlanPoint> coarser_ones() const {
    std::vector<FdkPlanPoint> out;
    const auto add = [&](auto FdkPlanPoint::*what, auto value) {
      out.push_back(plan.finest);
      out.back().*what = value;
    };
    for (const int every : strides_of(geometry, kMaxEvery)) add(&FdkPlanPoint::every, every);
    for (int rays = plan.finest.rays - 1; rays >= 1; --rays) add(&FdkPlanPoint::rays, rays);
    for (const double step : kSteps) add(&FdkPlanPoint::step, step);
    return out;
  }

  const Costs& costs(int rays, double step) {
    const auto [known, is_new] = known_costs.try_emplace({rays, step});
    if (!is_new) return known->second;
    // Distributed over the turn, because rays along an axis use caches and memory better than others.
    const int all = static_cast<int>(geometry.angles.size());
    double views[2] = {}, deposits[2] = {}, times[2] = {};
    for (const std::size_t i : {0, 1}) {
      const int every = std::max(1, all / (i == 0 ? 2 : 6));
      const ConeGeometry few = some_views(geometry, every);
      const Reconstruction made = reconstruct_fdk(timed, few, some_views(projections, geometry.angles.size(), every),
                                                  with({.rays = rays, .step = step}, asked));
      views[i] = static_cast<double>(few.angles.size());
      deposits[i] = static_cast<double>(made.deposits);
      times[i] = static_cast<double>(made.board_time);
      plan.pilot_deposits += deposits[i];
    }
    Costs& costs = known->second;
    costs.deposits = deposits[1] / views[1];
    costs.view = views[1] > views[0] ? std::max(0.0, times[1] - times[0]) / (views[1] - views[0]) : times[0] / views[0];
    costs.rest = std::max(0.0, times[0] - views[0] * costs.view);
    return costs;
  }

  void predict(FdkPlanPoint& point) {
    const Costs& each = costs(point.rays, point.step);
    const auto views = static_cast<double>(some_views(geometry, point.every).angles.size());
    point.deposits = views * each.deposits;
    point.time = static_cast<Picoseconds>(views * each.view + each.rest);
  }

  // Combined error if the errors of the single parameters are independent.
  std::vector<FdkPlanPoint> together(const std::vector<FdkPlanPoint>& singles) {
    std::vector<FdkPlanPoint> all{plan.finest};
    const auto add = [&](auto FdkPlanPoint::*what) {
      const std::vector<FdkPlanPoint> before = all;
      for (const FdkPlanPoint& one : singles) {
        if (one.*what == plan.finest.*what) continue;
        for (FdkPlanPoint point : before) {
          point.*what = one.*what;
          point.error = std::hypot(point.error, one.error);
          point.error_bound = std::hypot(point.error_bound, one.error_bound);
          all.push_back(point);
        }
      }
    };
    add(&FdkPlanPoint::every);
    add(&FdkPlanPoint::rays);
    add(&FdkPlanPoint::step);
    for (FdkPlanPoint& point : all) predict(point);
    return all;
  }

  // Chooses the cheapest pilot whose bound keeps the target. Tries cheaper combinations that are predicted to keep it,
  // cheapest first.
  void choose_cheapest(std::vector<FdkPlanPoint> all) {
    const auto cost = [](const FdkPlanPoint& point) { return point.deposits; };
    const double max_error = plan.target.max_error;
    plan.chosen = plan.finest;  // the reference of all errors
    plan.kept = true;
    if (const FdkPlanPoint* point = cheapest_kept(plan.points, max_error, cost); point != nullptr) {
      if (cost(*point) < cost(plan.chosen)) plan.chosen = *point;
    }
    std::ranges::stable_sort(all, {}, cost);
    int tries = 0;
    for (const FdkPlanPoint& candidate : all) {
      if (cost(candidate) >= cost(plan.chosen) || tries == kTries) return;
      if (candidate.error_bound > max_error || coarser_ways(candidate) < 2) continue;
      ++tries;
      const FdkPlanPoint point = tried(candidate);
      if (point.error_bound > max_error) continue;
      plan.chosen = point;
      return;
    }
  }

  // Number of parameters that are coarser than in the finest setting; settings with one have been tried.
  int coarser_ways(const FdkPlanPoint& point) const {
    const FdkPlanPoint& finest = plan.finest;
    return (point.every != finest.every) + (point.rays != finest.rays) + (point.step != finest.step);
  }

  // Chooses the most accurate setting that is predicted to keep the budget, and keeps it on the board whose time
  // counts.
  void choose_within_time(std::vector<FdkPlanPoint> all) {
    const Picoseconds budget = plan.target.time_budget;
    std::ranges::stable_sort(all, [&](const FdkPlanPoint& a, const FdkPlanPoint& b) {
      const bool fits = a.time <= budget;
      if (fits != (b.time <= budget)) return fits;
      return fits ? a.error_bound < b.error_bound : a.time < b.time;
    });
    for (const FdkPlanPoint& point : all) {
      const Reconstruction made = reconstruct_fdk(timed, some_views(geometry, point.every),
                                                  some_views(projections, plan.views, point.every), with(point, asked));
      plan.pilot_deposits += static_cast<double>(made.deposits);
      plan.kept = kAgain * static_cast<double>(made.board_time) <= static_cast<double>(budget);
      if (!plan.kept && point.time <= budget && &point != &all.back()) continue;
      plan.chosen = tried(point);
      plan.chosen.deposits = static_cast<double>(made.deposits);
      plan.chosen.time = made.board_time;
      return;
    }
  }
};

}  // namespace

FdkSettings FdkPlan::settings(const FdkSettings& original) const { return with(chosen, original); }

std::vector<std::string> FdkPlan::explain() const {
  const auto words = [](const FdkPlanPoint& point) {
    return fmt::format("{} x {} rays per pixel, step {:g}", point.rays, point.rays, point.step);
  };
  constexpr const char* kFinest = "the finest setting";
  const auto every = static_cast<std::size_t>(chosen.every);
  return {plan_headline("", target, kept),
          every == 1 ? fmt::format("views: all {}", views)
                     : fmt::format("views: {} of {}, each {}th", (views + every - 1) / every, views, every),
          "rays: " + words(chosen),
          plan_error_line(chosen.error, fmt::format("in a pilot of {} slices around the middle", slices),
                          chosen.error_bound),
          fmt::format("that is within {:.4g} of the axis and {:.4g} of the middle plane, which all views see",
                      field.radius, field.half_height),
          plan_cost_line("deposits", chosen.deposits, kFinest, finest.deposits),
          plan_time_line(chosen.time, kFinest, finest.time),
          "the finest setting: all views, " + words(finest),
          fmt::format("the plan itself: {} pilots, {} deposits, {:.2f} s of the host", pilots,
                      count_text(pilot_deposits), host_seconds)};
}

FdkPlan plan_fdk(Board& board, const ConeGeometry& geometry, const Projections& projections,
                 const FdkSettings& settings, const PlanTarget& target, const Progress& progress, Board* timed) {
  check(geometry);
  check(projections, geometry);
  if ((target.max_error > 0) == (target.time_budget > 0)) {
    throw BadArgument("time_budget", "one of max_error and time_budget", target.max_error > 0 ? "both" : "none");
  }
  FdkPlan plan;
  plan.target = target;
  return Planner{board, timed != nullptr ? *timed : board, geometry, projections, settings, progress, plan}.make();
}

}  // namespace gicube::samples

// The plan step: makes pilots for a grid of settings and chooses among them.
#include "gicube/plan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <span>

#include "encode/argument.h"
#include "encode/camera.h"
#include "plan/levels.h"
#include "plan/pilot.h"

namespace gicube {
namespace {

// Voxels, chosen: each costs half of the one before. Savings are relative to the finest.
constexpr double kSteps[] = {1.0 / 16, 1.0 / 8, 1.0 / 4, 1.0 / 2, 1, 2};
constexpr double kFinestStep = kSteps[0];
// chosen: on the paper's datapath shorter steps lose more by the drift of 14-bit positions, which grows with their
// number, than they gain; the wide one does not drift (docs/guide/plan.md has the measurements).
constexpr std::size_t kBestOnPaper = 2;
constexpr double kThresholds[] = {0.9, 0.95, 0.98, 0.99, 0.998};  // chosen; and 1
// chosen: whole pictures are made up to this multiple of the budget, because predictions may be too long.
constexpr double kTimeMargin = 1.25;
// chosen: the time of the same picture varies slightly with the previous state of the memory; 0.4% was measured.
constexpr double kAgain = 1.01;
// chosen: from this error on, one level of detail beyond that of the pixels is tried.
constexpr double kCoarse = 0.02;

void check_request(const PlanRequest& request) {
  check(request.view);
  expect_within("max_error", request.max_error, 0, 1);
  if (request.max_error > 0 && request.time_budget > 0) {
    throw BadArgument("time_budget", "one of max_error and time_budget", "both");
  }
  expect_within("pilot_pixels", request.pilot_pixels, 16, 512);
  if (!request.volume.samples.empty() && request.looks.empty()) {
    throw BadArgument("looks", "a transfer function for each tag of the volume", "none");
  }
}

PlanPoint settings(int level, double step, double threshold) {
  PlanPoint point;
  point.level = level;
  point.step = step;
  point.opacity_threshold = threshold;
  return point;
}

class Planner {
 public:
  Planner(Board& board, const PlanRequest& request, const Progress& progress)
      : board_(board),
        request_(request),
        progress_(progress),
        keeps_time_(board.info().fidelity != Fidelity::kFunctional),
        steps_(std::span(kSteps).subspan(board.info().wide ? 0 : kBestOnPaper)),
        levels_(board, request.volume, request.looks, request.view.shade) {}

  Plan make() {
    const auto start = std::chrono::steady_clock::now();
    if (request_.time_budget > 0 && !keeps_time_) {
      throw BadArgument("time_budget", "a board with fidelity level cycle, which models time", "functional");
    }
    describe();
    take_best();
    plan_.chosen = plan_.best;
    if (request_.max_error > 0 || request_.time_budget > 0) {
      for (int level = 0; level <= deepest_; ++level) try_level(level);
      request_.max_error > 0 ? choose_cheapest() : choose_within_time();
    }
    go_to(where_);
    if (keeps_time_ && (request_.time_budget == 0 || !plan_.kept)) plan_.chosen.time = made_time(plan_.chosen, where_);
    plan_.placement = levels_.placement(where_);
    plan_.dims = levels_.dims(where_);
    if (where_ == Levels::kWhole) plan_.box = {{}, plan_.dims};
    plan_.level_errors = levels_.errors();
    plan_.fidelity = request_.time_budget > 0 ? Fidelity::kCycle : Fidelity::kFunctional;
    plan_.pilot_host_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    plan_.request = request_;
    plan_.request.volume = {};
    plan_.request.looks = {};
    if (progress_) progress_(max_pilots_, max_pilots_);
    return std::move(plan_);
  }

 private:
  void describe() {
    plan_.gradients = request_.view.shade;
    if (levels_.own()) {
      plan_.box = levels_.box();
      plan_.original_dims = request_.volume.dims;
      plan_.voxels_a_pixel = voxels_a_pixel(request_.view, levels_.seen(), request_.volume.spacing);
      plan_.level_for_pixels = level_for(plan_.voxels_a_pixel);
      const bool deeper = request_.time_budget > 0 || request_.max_error >= kCoarse;
      deepest_ = std::min(plan_.level_for_pixels + (deeper ? 1 : 0), levels_.max_level());
    }
    max_pilots_ = static_cast<std::uint32_t>(static_cast<std::size_t>(deepest_ + 1) * steps_.size() *
                                             (std::size(kThresholds) + 1));
  }

  // Goes to a level. After a load a tiny pilot sends the tables of this camera, so that no other pilot pays for them.
  void go_to(int level) {
    if (levels_.go_to(level) || plan_.pilots == 0) static_cast<void>(take(settings(level, 2, 0.5), 4, level));
  }

  Pilot take(const PlanPoint& point, int edge, int where) {
    return take(point, pilot_view(request_.view, edge), where);
  }

  Pilot take(const PlanPoint& point, const View& asked, int where) {
    View view = levels_.placement(where).view(asked);
    view.step = point.step;
    view.opacity_threshold = point.opacity_threshold;
    Pilot pilot = take_pilot(board_, view);
    ++plan_.pilots;
    plan_.pilot_samples += pilot.samples;
    if (progress_) progress_(std::min(plan_.pilots, max_pilots_ - 1), max_pilots_);
    return pilot;
  }

  double rays() const {
    const View& view = request_.view;
    return double(view.width) * view.height * view.samples_per_axis * view.samples_per_axis;
  }
  int first_edge() const { return request_.pilot_pixels; }
  int second_edge() const {
    constexpr double kShare = 1.0 / 3;  // chosen: of the picture's edge, so a ninth of its pixels
    return std::max(2 * request_.pilot_pixels, static_cast<int>(kShare * picture_edge()));
  }
  double picture_edge() const { return std::sqrt(double(request_.view.width) * request_.view.height); }
  bool has_room() const { return second_edge() <= picture_edge(); }

  // Extrapolates samples and time of the whole picture by its number of rays.
  void extrapolate(const Pilot& pilot, PlanPoint& point) const {
    const double more = rays() / static_cast<double>(pilot.image.pixels.size());
    point.samples = more * pilot.samples;
    point.time = keeps_time_ ? static_cast<Picoseconds>(more * static_cast<double>(pilot.time)) : 0;
    point.pilot_width = pilot.image.width;
    point.pilot_height = pilot.image.height;
  }

  static void compare(PlanPoint& point, const Image& image, const Image& best) {
    const PilotError error = pilot_error(image, best);
    point.error = error.estimate;
    point.error_bound = error.bound;
  }

  // Makes the reference picture, from the whole volume.
  void take_best() {
    go_to(Levels::kWhole);
    const auto picture = [this](PlanPoint& point, int edge) {
      Pilot pilot = take(point, edge, Levels::kWhole);
      if (edge == first_edge()) extrapolate(pilot, point);
      return std::move(pilot.image);
    };
    plan_.best = settings(0, steps_.front(), 1);
    best_ = picture(plan_.best, first_edge());
    if (has_room()) larger_best_ = picture(plan_.best, second_edge());
    plan_.finest = plan_.best;
    if (plan_.best.step != kFinestStep) {
      plan_.finest = settings(0, kFinestStep, 1);
      compare(plan_.finest, picture(plan_.finest, first_edge()), best_);
    }
    if (keeps_time_) plan_.finest.time = rough_time(plan_.finest, Levels::kWhole);
  }

  PlanPoint tried(const PlanPoint& of, int edge) {
    PlanPoint point = of;
    const Pilot pilot = take(point, edge, point.level);
    extrapolate(pilot, point);
    compare(point, pilot.image, edge == first_edge() ? best_ : larger_best_);
    plan_.points.push_back(point);
    return point;
  }

  void try_level(int level) {
    go_to(level);
    for (const double step : steps_) {
      const PlanPoint whole = tried(settings(level, step, 1), first_edge());
      // Ending rays earlier, or longer steps, can't improve the picture.
      if (request_.max_error > 0 && whole.error > request_.max_error) break;
      for (const double threshold : kThresholds) {
        const PlanPoint point = tried(settings(level, step, threshold), first_edge());
        if (request_.max_error > 0 && point.error_bound <= request_.max_error) break;
      }
    }
  }

  double cost(const PlanPoint& point) const { return keeps_time_ ? static_cast<double>(point.time) : point.samples; }

  // Chooses the cheapest point whose bound is within the target. Small pilots have wide bounds: a point that is within
  // the target only by its estimate gets a larger pilot, if it is cheaper than the best so far.
  void choose_cheapest() {
    const auto keeps = [this](const PlanPoint& point) { return point.error_bound <= request_.max_error; };
    std::vector<PlanPoint> candidates;
    for (const PlanPoint& point : plan_.points) {
      const double error = has_room() ? point.error : point.error_bound;
      if (error <= request_.max_error) candidates.push_back(point);
    }
    std::sort(candidates.begin(), candidates.end(),
              [this](const PlanPoint& a, const PlanPoint& b) { return cost(a) < cost(b); });
    for (const PlanPoint& candidate : candidates) {
      if (cost(candidate) >= cost(plan_.chosen)) break;
      const PlanPoint point = keeps(candidate) ? candidate : closer(candidate);
      if (keeps(point) && cost(point) < cost(plan_.chosen)) choose(point);
    }
  }

  void choose(const PlanPoint& point) {
    plan_.chosen = point;
    where_ = point.level;
  }

  // Makes a larger pilot of a point. Keeps its time if a budget has determined it.
  PlanPoint closer(const PlanPoint& point) {
    go_to(point.level);
    PlanPoint found = tried(point, second_edge());
    if (request_.time_budget > 0) found.time = point.time;
    return found;
  }

  TimePoint timed(const PlanPoint& point, int edge, int where) {
    const Pilot pilot = take(point, edge, where);
    return {static_cast<double>(pilot.image.pixels.size()), static_cast<double>(pilot.time)};
  }

  // Estimates the whole picture's time from small pilots, to decide whether to make it.
  Picoseconds rough_time(const PlanPoint& point, int where) {
    go_to(where);
    constexpr int kTiny = 4;  // pixels: for the time before the first ray
    const TimePoint none = timed(point, kTiny, where), small = timed(point, first_edge(), where);
    const TimePoint large = has_room() ? timed(point, 2 * first_edge(), where) : TimePoint{};
    return static_cast<Picoseconds>(extrapolated_time(none, small, large, rays()));
  }

  Picoseconds made_time(const PlanPoint& point, int where) {
    go_to(where);
    return take(point, request_.view, where).time;
  }

  void choose_within_time() {
    const auto budget = static_cast<double>(request_.time_budget);
    constexpr double kAtBest = 0.3;  // chosen: least share of a pilot's time per ray that closer rays need
    std::vector<PlanPoint> points = plan_.points;
    std::stable_sort(points.begin(), points.end(),
                     [](const PlanPoint& a, const PlanPoint& b) { return a.error_bound < b.error_bound; });
    for (PlanPoint& point : points) {
      if (kAtBest * static_cast<double>(point.time) > budget) continue;
      if (static_cast<double>(rough_time(point, point.level)) > kTimeMargin * budget) continue;
      point.time = made_time(point, point.level);
      if (kAgain * static_cast<double>(point.time) > budget) continue;
      choose(has_room() ? closer(point) : point);
      return;
    }
    plan_.kept = false;
    choose(*std::min_element(points.begin(), points.end(),
                             [](const PlanPoint& a, const PlanPoint& b) { return a.time < b.time; }));
  }

  Board& board_;
  const PlanRequest& request_;
  const Progress& progress_;
  const bool keeps_time_;
  const std::span<const double> steps_;  // the best one first
  Levels levels_;
  int deepest_ = 0;
  int where_ = Levels::kWhole;  // the level of the chosen point, or kWhole
  std::uint32_t max_pilots_ = 0;
  Image best_, larger_best_;
  Plan plan_;
};

}  // namespace

View Plan::view(const View& original) const {
  View view = placement.view(original);
  view.step = chosen.step;
  view.opacity_threshold = chosen.opacity_threshold;
  return view;
}

Plan make_plan(Board& board, const PlanRequest& request, const Progress& progress) {
  check_request(request);
  return Planner(board, request, progress).make();
}

void load_planned(Board& board, const Plan& plan, const VolumeView& volume, std::span<const TransferFunction> looks) {
  std::optional<DerivedVolume> part, coarse;
  if (plan.box.size != volume.dims) part = cropped(volume, plan.box);
  VolumeView view = without_unused(part ? part->view() : volume, plan.gradients);
  if (plan.chosen.level > 0) {
    coarse = coarser(view, plan.chosen.level);
    view = without_unused(coarse->view(), plan.gradients);
  }
  load_with_looks(board, view, plan.placement, looks);
}

}  // namespace gicube

// The plan step of light: tries pairs of passes and chooses among them.
#include "gicube/light_plan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "encode/argument.h"
#include "encode/camera.h"
#include "encode/lights.h"
#include "plan/pilot.h"

namespace gicube {
namespace {

constexpr double kBestLightStep =
    0.5;  // voxels, chosen: what longer steps are held against (docs/studies/charts.md, Lighting)
constexpr double kLongStep = 1;  // chosen: at 2, low albedo deposits light in wrong places
constexpr int kFirstRays = 8;    // chosen: enough that few pixels clip
constexpr double kWorthIt =
    0.7;  // chosen: another albedo or step must cost less than this, for what its comparison costs
constexpr double kMoreRays = 1.1;  // chosen: of the number that the noise predicts
constexpr double kGrowth = 1.5;    // chosen: at least, after a failure: with rounded words noise falls more slowly
constexpr int kMaxGrowth = 4;      // chosen: at once, since noise may fall more slowly or not at all
constexpr double kNoGain = 0.95;   // chosen: of the previous bound; above, rounding of the words dominates
constexpr int kTries = 8;
constexpr double kLightTimeMargin = 1.25;  // as for pictures

void check_request(const LightPlanRequest& request, int irradiance_words) {
  for (std::size_t i = 0; i < request.lights.size(); ++i) check(request.lights[i], fmt::format("lights[{}]", i));
  check(request.settings, request.lights.size(), irradiance_words);
  check(request.view);
  expect_within("max_error", request.max_error, 0, 1);
  if ((request.max_error > 0) == (request.time_budget > 0)) {
    throw BadArgument("time_budget", "one of max_error and time_budget", request.max_error > 0 ? "both" : "none");
  }
  expect_within("channel", request.channel, -1, 2);
  expect_within("max_rays", request.max_rays, 1, 4096);
  expect_within("pilot_pixels", request.pilot_pixels, 16, 512);
}

struct Mode {
  Albedo albedo = Albedo::kLow;
  double step = kBestLightStep;

  bool operator==(const Mode&) const = default;
};

// Two passes of one setting.
struct Pair {
  LightPoint point;
  Image a, b;
};

class LightPlanner {
 public:
  LightPlanner(Board& board, const LightPlanRequest& request, const Progress& progress)
      : board_(board),
        request_(request),
        progress_(progress),
        keeps_time_(board.info().fidelity != Fidelity::kFunctional),
        best_{request.settings.rules == EnergyRules::kConserving ? Albedo::kLow : request.settings.albedo,
              std::min(request.settings.step, kBestLightStep)} {
    view_ = pilot_view(request.view, request.pilot_pixels);
    view_.irradiance = true;
  }

  LightPlan make() {
    const auto start = std::chrono::steady_clock::now();
    if (request_.time_budget > 0 && !keeps_time_) {
      throw BadArgument("time_budget", "a board with fidelity level cycle, which models time", "functional");
    }
    plan_.target = {request_.max_error, request_.time_budget};
    plan_.channel = request_.channel;
    first_pilots();
    request_.max_error > 0 ? choose_cheapest() : choose_within_time();
    plan_.asked = expected(nearest_to_asked(), request_.settings.rays_per_face_voxel);
    plan_.asked.step = request_.settings.step;
    plan_.host_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (progress_) progress_(kParts, kParts);
    return std::move(plan_);
  }

 private:
  static constexpr std::uint32_t kParts = 16;  // of the progress

  // All modes, the best one first.
  std::vector<Mode> modes() const {
    std::vector<Mode> all{best_};
    const bool both = request_.settings.rules == EnergyRules::kConserving;
    for (const Albedo albedo : {Albedo::kLow, Albedo::kHigh}) {
      if (!both && albedo != request_.settings.albedo) continue;
      for (const double step : {best_.step, kLongStep}) {
        if (!(Mode{albedo, step} == best_)) all.push_back({albedo, step});
      }
    }
    return all;
  }

  Image pass(const LightPoint& setting, std::uint32_t seed, LightPoint* cost) {
    Illumination settings = request_.settings;
    settings.albedo = setting.albedo;
    settings.step = setting.step;
    settings.rays_per_face_voxel = setting.rays_per_face_voxel;
    settings.seed = seed;
    const Counters before = board_.counters();
    const Picoseconds begin = board_.now();
    const LightingReport report = board_.illuminate(request_.lights, settings);
    const Picoseconds time = board_.now() - begin;
    const auto samples = static_cast<double>((board_.counters() - before).value("pipeline.samples"));
    if (cost != nullptr) {
      cost->rays = static_cast<double>(report.rays);
      cost->samples = samples;
      cost->time = keeps_time_ ? time : 0;
    }
    plan_.pass_samples += samples;
    ++plan_.passes;
    if (progress_) progress_(std::min(plan_.passes, kParts - 1), kParts);
    return board_.render(view_);
  }

  // The pass with the request's seed comes last, so that its light stays on the board.
  Pair take(const Mode& mode, int rays) {
    Pair pair;
    pair.point.albedo = mode.albedo;
    pair.point.step = mode.step;
    pair.point.rays_per_face_voxel = rays;
    pair.b = pass(pair.point, request_.settings.seed + ++seeds_, nullptr);
    pair.a = pass(pair.point, request_.settings.seed, &pair.point);
    const PilotError noise = noise_of(pair.a, pair.b, request_.channel);
    pair.point.noise = pair.point.error = noise.estimate;
    pair.point.error_bound = noise.bound;
    return pair;
  }

  void add_bias(Pair& pair, const Image& best_a, const Image& best_b) const {
    const PilotError bias = bias_of(pair.a, pair.b, best_a, best_b, request_.channel);
    pair.point.bias = bias.estimate;
    pair.point.error = std::hypot(pair.point.noise, bias.estimate);
    pair.point.error_bound = std::hypot(pair.point.error_bound, bias.bound);
  }

  void first_pilots() {
    const int rays = std::min(kFirstRays, request_.max_rays);
    for (const Mode& mode : modes()) {
      Pair pair = take(mode, rays);
      if (!firsts_.empty()) add_bias(pair, firsts_.front().a, firsts_.front().b);
      plan_.points.push_back(pair.point);
      firsts_.push_back(std::move(pair));
    }
  }

  // The passes nearest to the request's settings: of the same albedo, then of the nearest step, then of the nearest
  // number of rays.
  const LightPoint& nearest_to_asked() const {
    const Illumination& asked = request_.settings;
    const auto distance = [&](const LightPoint& point) {
      return std::tuple(point.albedo != asked.albedo, std::abs(point.step - asked.step),
                        std::abs(std::log(double(point.rays_per_face_voxel) / asked.rays_per_face_voxel)));
    };
    return *std::min_element(plan_.points.begin(), plan_.points.end(),
                             [&](const LightPoint& a, const LightPoint& b) { return distance(a) < distance(b); });
  }

  // Predicts another number of rays: the variance is inversely proportional to it, the bias is constant.
  static LightPoint expected(const LightPoint& of, int rays) {
    LightPoint point = of;
    const double more = static_cast<double>(rays) / of.rays_per_face_voxel;
    point.rays_per_face_voxel = rays;
    point.noise = of.noise / std::sqrt(more);
    point.error = std::hypot(point.noise, of.bias);
    point.error_bound = of.error_bound * point.error / std::max(of.error, 1e-12);
    point.rays *= more;
    point.samples *= more;
    point.time = static_cast<Picoseconds>(static_cast<double>(of.time) * more);
    return point;
  }

  // Rays per face voxel for an error; more than max_rays if those do not suffice.
  int rays_for(const LightPoint& of, double error) const {
    const double beyond = 2.0 * request_.max_rays;
    const double factor = of.error > 0 ? of.error_bound / of.error : 1;  // how far the bound is above the error
    const double wished = error * error / (factor * factor) - of.bias * of.bias;
    if (!(wished > 0)) return static_cast<int>(beyond);
    const double rays = kMoreRays * of.rays_per_face_voxel * of.noise * of.noise / wished;
    return static_cast<int>(std::clamp(std::ceil(rays), 1.0, beyond));
  }

  double cost(const LightPoint& point) const { return keeps_time_ ? static_cast<double>(point.time) : point.samples; }

  // Measures the error; that of other modes against the best mode with as many rays.
  LightPoint decided(const Mode& mode, int rays) {
    Image best_a, best_b;
    if (!(mode == best_)) {
      Pair best = take(best_, rays);
      best_a = std::move(best.a);
      best_b = std::move(best.b);
    }
    Pair pair = take(mode, rays);
    if (!(mode == best_)) add_bias(pair, best_a, best_b);
    plan_.points.push_back(pair.point);
    return pair.point;
  }

  struct Candidate {
    Mode mode;
    int rays = 0;
    double cost = 0;
  };

  // The best mode, after those that are so much cheaper that a comparison is worth its cost.
  std::vector<Candidate> candidates() const {
    std::vector<Candidate> out;
    for (const Pair& pair : firsts_) {
      const int rays = rays_for(pair.point, request_.max_error);
      out.push_back({{pair.point.albedo, pair.point.step}, rays, cost(expected(pair.point, rays))});
    }
    const Candidate best = out.front();
    std::erase_if(out, [&](const Candidate& one) {
      if (one.mode == best_) return false;
      const bool within = one.rays <= request_.max_rays;
      return !within || (best.rays <= request_.max_rays && one.cost > kWorthIt * best.cost);
    });
    std::sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
    return out;
  }

  void choose_cheapest() {
    for (const Candidate& candidate : candidates()) {
      int rays = std::min({candidate.rays, request_.max_rays, kMaxGrowth * kFirstRays});
      double last = std::numeric_limits<double>::infinity();
      for (int attempt = 0; attempt < kTries; ++attempt) {
        plan_.chosen = decided(candidate.mode, rays);
        plan_.kept = plan_.chosen.error_bound <= request_.max_error;
        plan_.at_limit = !plan_.kept && plan_.chosen.error_bound > kNoGain * last;
        if (plan_.kept || plan_.at_limit || rays == request_.max_rays) break;
        last = plan_.chosen.error_bound;
        const int more =
            std::max(rays_for(plan_.chosen, request_.max_error), static_cast<int>(std::ceil(kGrowth * rays)));
        rays = std::min(std::min(more, kMaxGrowth * rays), request_.max_rays);
      }
      if (plan_.kept) break;
    }
    take_cheaper();
  }

  // A pilot may have found a cheaper setting that suffices: then its light stays on the board.
  void take_cheaper() {
    const LightPoint* const cheapest =
        cheapest_kept(plan_.points, request_.max_error, [this](const LightPoint& point) { return cost(point); });
    if (cheapest == nullptr || (plan_.kept && cost(*cheapest) >= cost(plan_.chosen))) return;
    plan_.chosen = *cheapest;
    plan_.kept = true;
    plan_.at_limit = false;
    static_cast<void>(pass(plan_.chosen, request_.settings.seed, nullptr));
  }

  void choose_within_time() {
    const auto budget = static_cast<double>(request_.time_budget) / kLightTimeMargin;
    LightPoint best;
    for (const Pair& pair : firsts_) {
      const double one = static_cast<double>(pair.point.time) / pair.point.rays_per_face_voxel;
      const int rays = static_cast<int>(std::clamp(std::floor(budget / one), 1.0, double(request_.max_rays)));
      const LightPoint point = expected(pair.point, rays);
      const auto better = [&](const LightPoint& a, const LightPoint& b) {
        const bool fits_a = static_cast<double>(a.time) <= budget, fits_b = static_cast<double>(b.time) <= budget;
        if (fits_a != fits_b) return fits_a;
        return fits_a ? a.error_bound < b.error_bound : a.time < b.time;
      };
      if (best.rays_per_face_voxel == 0 || better(point, best)) best = point;
    }
    for (int attempt = 0; attempt < kTries; ++attempt) {
      plan_.chosen = decided({best.albedo, best.step}, best.rays_per_face_voxel);
      plan_.kept = plan_.chosen.time <= request_.time_budget;
      if (plan_.kept || best.rays_per_face_voxel == 1) return;
      const double less = budget / static_cast<double>(plan_.chosen.time);
      best.rays_per_face_voxel = std::max(1, static_cast<int>(best.rays_per_face_voxel * less));
    }
  }

  Board& board_;
  const LightPlanRequest& request_;
  const Progress& progress_;
  const bool keeps_time_;
  const Mode best_;
  View view_;
  std::uint32_t seeds_ = 0;
  std::vector<Pair> firsts_;  // of the best mode first
  LightPlan plan_;
};

}  // namespace

Illumination LightPlan::settings(const Illumination& original) const {
  Illumination settings = original;
  settings.albedo = chosen.albedo;
  settings.step = chosen.step;
  settings.rays_per_face_voxel = chosen.rays_per_face_voxel;
  return settings;
}

double share_of_light(double max_error) { return max_error / std::sqrt(2.0); }

double left_for_picture(double max_error, const LightPlan& light) {
  const double share = share_of_light(max_error), taken = std::min(share, light.chosen.error_bound);
  return std::sqrt(max_error * max_error - taken * taken);
}

LightPlan plan_light(Board& board, const LightPlanRequest& request, const Progress& progress) {
  check_request(request, board.info().irradiance_words);
  return LightPlanner(board, request, progress).make();
}

}  // namespace gicube

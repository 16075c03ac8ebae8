#include "cone_beam/algebraic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "gicube/parallel_for.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

constexpr double kWorseThanNothing = 2;  // chosen: residuals of nothing are 1
constexpr double kGrown = 1.02;          // chosen: which rounding and cut off negative values don't reach
constexpr int kPatience = 3;             // chosen: iterations

void check(const AlgebraicSettings& settings, const ConeGeometry& geometry, const Projections& projections) {
  check(geometry);
  const auto& [method, iterations, subsets, relaxation, order, non_negative, stop, noise, step, seed] = settings;
  expect(iterations >= 1, "iterations", "at least 1", iterations);
  expect(method != Method::kOsSart || (subsets >= 2 && subsets <= std::ssize(geometry.angles)), "subsets",
         "2..the number of views", subsets);
  expect(std::isfinite(relaxation) && relaxation > 0, "relaxation", "a finite number above 0", relaxation);
  expect(stop >= 0 && stop < 1, "stop", "0..1", stop);
  expect(std::isfinite(noise) && noise >= 0, "noise", "0 or a number above it", noise);
  expect(step >= 1.0 / 64 && step <= 16, "step", "1/64..16 voxels", step);
  check(projections, geometry);
}

// How much of what was measured a volume's projections miss.
struct Missing {
  double squares = 0, measured = 0;

  double relative() const { return measured == 0 ? 0 : std::sqrt(squares / measured); }
};

struct Loop {
  using Densities = std::vector<std::vector<double>>;  // of views

  Board& board;
  const ConeGeometry& geometry;
  const Projections& projections;
  const AlgebraicSettings& settings;
  std::vector<std::vector<std::size_t>> subsets = view_subsets(geometry.angles.size(), settings);
  std::vector<std::vector<float>> known_steps{subsets.size()};  // of subsets, once they are known
  Reconstruction out{.values = std::vector<float>(voxel_count(geometry.volume.dims))};

  Reconstruction run(const Progress& progress) {
    const Picoseconds begin = board.now();
    std::vector<float> best = out.values;
    double least = 1;  // of nothing
    int since = 0;
    bool grew = false;
    for (int iteration = 0; iteration < settings.iterations; ++iteration) {
      const double residual = iterate(iteration, progress);
      out.residuals.push_back(residual);
      out.iteration_ends.push_back(board.now() - begin);
      if (subsets.size() == 1 && iteration > 0) judge(residual, out.residuals[out.residuals.size() - 2]);
      if (out.diverged) break;
      const bool is_least = residual < least;
      const double lowered = is_least ? 1 - residual / least : 0;
      grew = !is_least && (grew || residual > kGrown * least);
      since = is_least ? 0 : since + 1;
      if (is_least) {
        least = residual;
        best = out.values;
        out.iterations = iteration + 1;
      }
      out.diverged = since >= kPatience && grew;
      const bool first = out.residuals.size() == 1;  // of SIRT's first, nothing's
      if (out.diverged || residual <= settings.noise || (!first && lowered < settings.stop)) break;
    }
    out.values = std::move(best);
    out.board_time = board.now() - begin;
    told(progress, settings.iterations, 0);
    return std::move(out);
  }

  void told(const Progress& progress, int iteration, std::uint32_t done) const {
    const auto all = static_cast<std::uint32_t>(subsets.size());
    if (progress)
      progress(static_cast<std::uint32_t>(iteration) * all + done,
               static_cast<std::uint32_t>(settings.iterations) * all);
  }

  // A correction that is not too large makes the projections of its own views better.
  void judge(double after, double before) {
    if (!(after <= kGrown * before)) out.diverged = true;  // also of what is not a number
  }

  // All subsets once. Stops where a residual says that the values are worse than nothing. The first subset is projected again
  // after its correction: non-negative values may circle for ever without growing.
  double iterate(int iteration, const Progress& progress) {
    Missing missing;
    std::uint32_t done = 0;
    bool first = subsets.size() > 1;
    for (const std::size_t subset : subset_order(subsets.size(), settings, iteration)) {
      told(progress, iteration, done++);
      Densities densities;
      const Missing here = project(subsets[subset], densities);
      missing.squares += here.squares;
      missing.measured += here.measured;
      judge(here.relative(), kWorseThanNothing);
      if (out.diverged) break;
      move(subset, backproject(subsets[subset], densities));
      if (std::exchange(first, false)) judge(project(subsets[subset], densities).relative(), here.relative());
      if (out.diverged) break;
    }
    return missing.relative();
  }

  std::vector<double> angles_of(const std::vector<std::size_t>& views) const {
    std::vector<double> angles;
    for (const std::size_t view : views) angles.push_back(geometry.angles[view]);
    return angles;
  }

  // What the views of a subset miss; and what each ray should have had more, by its length. Rays that cut a corner off are left out
  // of it all, since they say next to nothing, and loudly.
  Missing project(const std::vector<std::size_t>& views, Densities& densities) {
    load_values(board, geometry.volume, out.values);
    densities.clear();
    Missing missing;
    const auto take = [&](std::size_t i, const std::vector<float>& projected) {
      std::vector<double>& rays = densities.emplace_back(lengths_of(views[i]));
      for (std::size_t pixel = 0; pixel < rays.size(); ++pixel) {
        if (rays[pixel] == 0) continue;
        const double wanted = double{projections.view(views[i])[pixel]}, off = wanted - double{projected[pixel]};
        missing.squares += off * off;
        missing.measured += wanted * wanted;
        rays[pixel] = off / rays[pixel];
      }
    };
    out.rays += project_views(board, geometry, angles_of(views), settings.step, take);
    return missing;
  }

  std::vector<double> lengths_of(std::size_t view) const {
    const std::vector<HostRay> rays = view_rays(geometry, geometry.angles[view]);
    std::vector<double> lengths;
    for (const HostRay& ray : rays) lengths.push_back(ray.length < 1 ? 0 : length_in_space(geometry.volume, ray));
    return lengths;
  }

  std::vector<float> backproject(const std::vector<std::size_t>& views, const Densities& densities) {
    double most = 0;
    for (const auto& view : densities) {
      for (const double density : view) most = std::max(most, std::abs(density));
    }
    return gicube::samples::backproject(
        board, geometry, angles_of(views), {.step = settings.step, .max_density = most},
        [&](std::size_t i) { return densities[i]; }, out);
  }

  // What a correction is multiplied by: the relaxation over the splatted weights, 0 where rays say nothing of a voxel.
  std::vector<float> steps_of(const std::vector<std::size_t>& views) {
    Densities ones;  // what a density of one on all rays leaves
    for (const std::size_t view : views) {
      for (double& value : ones.emplace_back(lengths_of(view))) value = value > 0 ? 1 : 0;
    }
    std::vector<float> steps = backproject(views, ones);
    constexpr float kLeast = 1e-3F;  // chosen, of the greatest weight
    const float least = kLeast * std::ranges::max(steps);
    const auto relaxation = static_cast<float>(settings.relaxation);
    for (float& weight : steps) weight = weight <= least ? 0 : relaxation / weight;
    return steps;
  }

  void move(std::size_t subset, const std::vector<float>& corrections) {
    std::vector<float> steps = std::move(known_steps[subset]);
    if (steps.empty()) steps = steps_of(subsets[subset]);
    const float floor = settings.non_negative ? 0 : std::numeric_limits<float>::lowest();
    constexpr std::size_t kPart = 1 << 16;
    parallel_for_runs(steps.size(), kPart, 0, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const float moved = out.values[i] + corrections[i] * steps[i];
        out.values[i] = std::max(moved, floor);
      }
    });
    constexpr std::size_t kMaxBytes = std::size_t{1} << 30;  // chosen: else they are splatted again in each iteration
    if (subsets.size() * steps.size() * sizeof(float) <= kMaxBytes) known_steps[subset] = std::move(steps);
  }
};

}  // namespace

std::vector<std::vector<std::size_t>> view_subsets(std::size_t views, const AlgebraicSettings& settings) {
  const std::size_t count = settings.method == Method::kSart     ? views
                            : settings.method == Method::kOsSart ? static_cast<std::size_t>(settings.subsets)
                                                                 : 1;
  std::vector<std::vector<std::size_t>> subsets(count);
  for (std::size_t view = 0; view < views; ++view) subsets[view % count].push_back(view);
  return subsets;
}

std::vector<std::size_t> subset_order(std::size_t subsets, const AlgebraicSettings& settings, int iteration) {
  std::vector<std::size_t> order(subsets);
  std::iota(order.begin(), order.end(), 0);
  if (settings.order == ViewOrder::kRandom) {
    std::mt19937_64 engine(settings.seed + 0x9E3779B97F4A7C15U * static_cast<std::uint64_t>(iteration + 1));
    for (std::size_t i = subsets; i > 1; --i) std::swap(order[i - 1], order[engine() % i]);
  } else if (settings.order == ViewOrder::kGolden) {
    // The ranks of the fractions of multiples of the golden ratio: each is 0.62 of the way round from the one before.
    std::vector<std::size_t> sorted = order;
    std::ranges::sort(sorted, {},
                      [](std::size_t i) { return std::fmod(static_cast<double>(i) * 0.6180339887498949, 1); });
    for (std::size_t rank = 0; rank < subsets; ++rank) order[sorted[rank]] = rank;
  }
  return order;
}

Reconstruction reconstruct_algebraic(Board& board, const ConeGeometry& geometry, const Projections& projections,
                                     const AlgebraicSettings& settings, const Progress& progress) {
  check(settings, geometry, projections);
  return Loop{board, geometry, projections, settings}.run(progress);
}

}  // namespace gicube::samples

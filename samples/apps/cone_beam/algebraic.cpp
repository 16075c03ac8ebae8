#include "cone_beam/algebraic.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
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
  expect(settings.iterations >= 1, "iterations", "at least 1", settings.iterations);
  const bool by_subsets =
      settings.method == Method::kOsSart || settings.method == Method::kOsem || settings.method == Method::kTv;
  expect(!by_subsets || (settings.subsets >= 2 && settings.subsets <= std::ssize(geometry.angles)), "subsets",
         "2..the number of views", settings.subsets);
  expect(std::isfinite(settings.relaxation) && settings.relaxation > 0, "relaxation", "a finite number above 0",
         settings.relaxation);
  expect(settings.stop >= 0 && settings.stop < 1, "stop", "0..1", settings.stop);
  expect(std::isfinite(settings.noise) && settings.noise >= 0, "noise", "0 or a number above it", settings.noise);
  expect(settings.step >= 1.0 / 64 && settings.step <= 16, "step", "1/64..16 voxels", settings.step);
  expect(settings.tv_steps >= 1 && settings.tv_steps <= 1000, "tv_steps", "1..1000", settings.tv_steps);
  expect(settings.tv_weight >= 0 && settings.tv_weight <= 1, "tv_weight", "0..1", settings.tv_weight);
  const std::size_t voxels = voxel_count(geometry.volume.dims), given = settings.mask.size();
  expect(given == 0 || given == voxels, "mask", fmt::format("{} values, one a voxel", voxels),
         static_cast<double>(given));
  check(projections, geometry);
}

double square_sum(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += double{value} * double{value};
  return sum;
}

// Residual of a volume's projections.
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
  Projector projector = projector_of(board, geometry, settings.step);
  std::vector<std::vector<std::size_t>> subsets = view_subsets(geometry.angles.size(), settings);
  std::vector<std::size_t> order = subset_order(subsets.size());
  std::vector<std::vector<float>> known_weights{subsets.size()};  // of subsets, once they are known
  Reconstruction out{.values = std::vector<float>(voxel_count(geometry.volume.dims))};
  // kCgls: residual of all projections, the last direction, and the square of its gradient.
  std::vector<float> remainder{}, direction{};
  double steepness = 0;
  double tv_weight = settings.tv_weight;

  Reconstruction run(const Progress& progress) {
    const Picoseconds begin = board.now();
    if (settings.method == Method::kOsem) begin_evenly();
    std::vector<float> best = out.values;
    double least = 1;  // of nothing
    int since = 0;
    bool grew = false;
    for (int iteration = 0; iteration < settings.iterations; ++iteration) {
      const double residual =
          settings.method == Method::kCgls ? descend(iteration, progress) : iterate(iteration, progress);
      out.residuals.push_back(residual);
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
    out.rays = projector.counts().rays;
    out.deposits = projector.counts().deposits;
    out.overflowed = projector.counts().overflowed;
    told(progress, settings.iterations, 0);
    return std::move(out);
  }

  void told(const Progress& progress, int iteration, std::uint32_t done) const {
    const auto all = static_cast<std::uint32_t>(subsets.size());
    if (progress)
      progress(static_cast<std::uint32_t>(iteration) * all + done,
               static_cast<std::uint32_t>(settings.iterations) * all);
  }

  // A correction that is not too large improves the projections of its own views.
  void judge(double after, double before) {
    if (!(after <= kGrown * before)) out.diverged = true;  // also of what is not a number
  }

  // Corrects for all subsets once. Stops when a residual exceeds that of an empty volume by too much. Projects the
  // first subset again after its correction, because non-negative values may oscillate for ever without growing.
  double iterate(int iteration, const Progress& progress) {
    const std::vector<float> before = settings.method == Method::kTv ? out.values : std::vector<float>();
    Missing missing;
    std::uint32_t done = 0;
    bool first = subsets.size() > 1;
    for (const std::size_t subset : order) {
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
    if (!before.empty() && !out.diverged) flatten(before);
    return missing.relative();
  }

  // Residual of a subset's views, and the correction of each ray over its length, or for kOsem its factor. Omits rays
  // that only cut a corner, because they carry little information and much noise.
  Missing project(const std::vector<std::size_t>& views, Densities& densities) {
    constexpr double kDark = 1e-3;  // chosen: of a ray of the mean value, which no ratio is taken over less of
    densities.clear();
    Missing missing;
    projector.project(out.values, views, [&](std::size_t i, const std::vector<float>& projected) {
      std::vector<double>& rays = densities.emplace_back(lengths_of(views[i]));
      for (std::size_t pixel = 0; pixel < rays.size(); ++pixel) {
        if (rays[pixel] == 0) continue;
        const double wanted = double{projections.view(views[i])[pixel]}, off = wanted - double{projected[pixel]};
        missing.squares += off * off;
        missing.measured += wanted * wanted;
        rays[pixel] = settings.method == Method::kOsem
                          ? std::max(wanted, 0.0) / std::max(double{projected[pixel]}, kDark * even_value * rays[pixel])
                          : off / rays[pixel];
      }
    });
    return missing;
  }

  std::vector<double> lengths_of(std::size_t view) const {
    std::vector<double> lengths;
    for (const HostRay& ray : projector.rays(view)) lengths.push_back(ray.length < 1 ? 0 : projector.length_of(ray));
    return lengths;
  }

  std::vector<float> backproject(const std::vector<std::size_t>& views, const Densities& densities) {
    double most = 0;
    for (const auto& view : densities) {
      for (const double density : view) most = std::max(most, std::abs(density));
    }
    return projector.backproject(views, most, [&](std::size_t i) { return densities[i]; });
  }

  // Sums of a density of one on all rays; 0 for voxels that rays hardly reach.
  std::vector<float> weights_of(const std::vector<std::size_t>& views) {
    Densities ones;
    for (const std::size_t view : views) {
      for (double& value : ones.emplace_back(lengths_of(view))) value = value > 0 ? 1 : 0;
    }
    std::vector<float> weights = backproject(views, ones);
    constexpr float kLeast = 1e-3F;  // chosen, of the greatest weight
    const float least = kLeast * std::ranges::max(weights);
    for (float& weight : weights) weight = weight <= least ? 0 : weight;
    mask(weights);
    return weights;
  }

  void mask(std::vector<float>& values) const {
    for (std::size_t i = 0; i < settings.mask.size(); ++i) values[i] = settings.mask[i] == 0 ? 0 : values[i];
  }

  void move(std::size_t subset, const std::vector<float>& corrections) {
    std::vector<float> weights = std::move(known_weights[subset]);
    if (weights.empty()) weights = weights_of(subsets[subset]);
    const bool multiplies = settings.method == Method::kOsem;
    const auto relaxation = static_cast<float>(settings.relaxation);
    const float floor = settings.non_negative ? 0 : std::numeric_limits<float>::lowest();
    constexpr std::size_t kPart = 1 << 16;
    parallel_for_runs(weights.size(), kPart, 0, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (weights[i] == 0) continue;
        const float change = corrections[i] / weights[i];
        out.values[i] = std::max(multiplies ? out.values[i] * change : out.values[i] + relaxation * change, floor);
      }
    });
    constexpr std::size_t kMaxBytes = std::size_t{1} << 30;  // chosen: else they are splatted again in each iteration
    if (subsets.size() * weights.size() * sizeof(float) <= kMaxBytes) known_weights[subset] = std::move(weights);
  }

  double even_value = 0;  // kOsem: what it begins with
  void begin_evenly() {
    double measured = 0, lengths = 0;
    for (std::size_t view = 0; view < geometry.angles.size(); ++view) {
      const std::vector<double> of_rays = lengths_of(view);
      for (std::size_t i = 0; i < of_rays.size(); ++i) {
        if (of_rays[i] == 0) continue;
        measured += std::max(0.0, double{projections.view(view)[i]});
        lengths += of_rays[i];
      }
    }
    even_value = lengths > 0 ? measured / lengths : 0;
    std::ranges::fill(out.values, static_cast<float>(even_value));
    mask(out.values);
  }

  // One iteration of kCgls.
  double descend(int iteration, const Progress& progress) {
    told(progress, iteration, 0);
    if (iteration == 0) remainder = projections.values;
    if (direction.empty()) turn();
    if (steepness == 0) return std::sqrt(square_sum(remainder) / std::max(square_sum(projections.values), 1e-300));
    const std::vector<float> seen = projector.project(direction);
    const double step = steepness / square_sum(seen);
    for (std::size_t i = 0; i < direction.size(); ++i) out.values[i] += static_cast<float>(step * double{direction[i]});
    for (std::size_t i = 0; i < seen.size(); ++i) remainder[i] -= static_cast<float>(step * double{seen[i]});
    turn();
    return std::sqrt(square_sum(remainder) / square_sum(projections.values));
  }

  // Next direction: downhill, and conjugate to the last.
  void turn() {
    std::vector<float> gradient = projector.backproject(remainder);
    mask(gradient);
    const double before = std::exchange(steepness, square_sum(gradient));
    const double kept = direction.empty() || before == 0 ? 0 : steepness / before;
    direction.resize(gradient.size());
    for (std::size_t i = 0; i < gradient.size(); ++i)
      direction[i] = gradient[i] + static_cast<float>(kept) * direction[i];
  }

  // kTv: reduces the total variation.
  void flatten(const std::vector<float>& before) {
    const auto distance = [this](const std::vector<float>& from) {
      double sum = 0;
      for (std::size_t i = 0; i < from.size(); ++i) sum += std::pow(double{out.values[i]} - double{from[i]}, 2);
      return std::sqrt(sum);
    };
    const double changed = distance(before);
    const std::vector<float> measured = out.values;
    for (int step = 0; step < settings.tv_steps; ++step) {
      std::vector<float> slope = tv_gradient(out.values, geometry.volume.dims);
      mask(slope);
      const double size = std::sqrt(square_sum(slope));
      if (size == 0) return;
      const auto by = static_cast<float>(tv_weight * changed / size);
      const float floor = settings.non_negative ? 0 : std::numeric_limits<float>::lowest();
      for (std::size_t i = 0; i < slope.size(); ++i) out.values[i] = std::max(out.values[i] - by * slope[i], floor);
    }
    constexpr double kMost = 0.95, kLess = 0.95;  // as Sidky and Pan have them
    if (distance(measured) > kMost * changed) tv_weight *= kLess;
  }
};

}  // namespace

std::vector<float> tv_gradient(const std::vector<float>& values, const Dims& dims) {
  const auto columns = static_cast<std::size_t>(dims[0]), rows = static_cast<std::size_t>(dims[1]);
  const auto slices = static_cast<std::size_t>(dims[2]);
  const std::array<std::size_t, 3> strides{1, columns, columns * rows};
  constexpr float kSmooth = 1e-6F;  // chosen: of the greatest value, against a division by nothing
  float most = 0;
  for (const float value : values) most = std::max(most, std::abs(value));
  const float least = kSmooth * most * kSmooth * most;
  // Normalised differences to the next voxel on each axis, and their divergence at each voxel.
  std::array<std::vector<float>, 3> flows;
  for (auto& flow : flows) flow.resize(values.size());
  const auto place = [&](std::size_t i) { return std::array{i % columns, i / columns % rows, i / strides[2]}; };
  const std::array<std::size_t, 3> last{columns - 1, rows - 1, slices - 1};
  parallel_for_runs(values.size(), strides[2], 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto at = place(i);
      std::array<float, 3> rise{};
      float square = least;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (at[axis] < last[axis]) rise[axis] = values[i + strides[axis]] - values[i];
        square += rise[axis] * rise[axis];
      }
      const float size = std::sqrt(square);
      for (std::size_t axis = 0; axis < 3; ++axis) flows[axis][i] = size == 0 ? 0 : rise[axis] / size;
    }
  });
  std::vector<float> out(values.size());
  parallel_for_runs(values.size(), strides[2], 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto at = place(i);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        out[i] += (at[axis] == 0 ? 0 : flows[axis][i - strides[axis]]) - flows[axis][i];
      }
    }
  });
  return out;
}

std::vector<std::vector<std::size_t>> view_subsets(std::size_t views, const AlgebraicSettings& settings) {
  const std::size_t count = settings.method == Method::kSart ? views
                            : settings.method == Method::kSirt || settings.method == Method::kCgls
                                ? 1
                                : static_cast<std::size_t>(settings.subsets);
  std::vector<std::vector<std::size_t>> subsets(count);
  for (std::size_t view = 0; view < views; ++view) subsets[view % count].push_back(view);
  return subsets;
}

std::vector<std::size_t> subset_order(std::size_t subsets) {
  std::vector<std::size_t> sorted(subsets), order(subsets);
  std::iota(sorted.begin(), sorted.end(), 0);
  // Ranks of the fractional parts of multiples of the golden ratio.
  std::ranges::sort(sorted, {},
                    [](std::size_t i) { return std::fmod(static_cast<double>(i) * 0.6180339887498949, 1); });
  for (std::size_t rank = 0; rank < subsets; ++rank) order[sorted[rank]] = rank;
  return order;
}

Reconstruction reconstruct_algebraic(Board& board, const ConeGeometry& geometry, const Projections& projections,
                                     const AlgebraicSettings& settings, const Progress& progress) {
  check(settings, geometry, projections);
  return Loop{board, geometry, projections, settings}.run(progress);
}

}  // namespace gicube::samples

#include "form_factors/plan/plan.h"

#include <fmt/format.h>

#include <cmath>

#include "scene/program/input_error.h"

namespace gicube::samples {
namespace {

// What the result's own standard errors make one expect of the difference: the mean of |x| of a normal distribution.
double expected_noise(const RadiosityResult& result) {
  const double mean_of_normal = std::sqrt(2 / std::acos(-1.0));
  double noise = 0, all = 0;
  for (std::size_t i = 0; i < result.leaves.size(); ++i) {
    const Leaf& leaf = result.leaves[i];
    if (leaf.tag == kOutside) continue;
    noise += mean_of_normal * leaf.weight * result.standard_error[i];
    for (const double channel : result.incident[i]) all += leaf.weight * channel;
  }
  return noise / all;
}

}  // namespace

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

std::vector<StudyPoint> study_hierarchy(Board& board, const SceneSetup& setup, const Emissions& emissions,
                                        const RadiositySettings& settings, const std::vector<double>& errors, bool full,
                                        const RadiosityProgress& progress) {
  constexpr int kMoreRays = 4;  // chosen: halves the noise
  RadiositySettings exact = settings;
  exact.hierarchy = false;
  exact.rays = settings.rays * kMoreRays;
  exact.max_rays = std::max(settings.max_rays, exact.rays);
  exact.seed = settings.seed + 1;
  const RadiosityResult reference = solve_radiosity(board, setup, emissions, exact, progress);

  std::vector<StudyPoint> points;
  for (std::size_t i = 0; i < errors.size() + (full ? 1 : 0); ++i) {
    RadiositySettings changed = settings;
    changed.hierarchy = i < errors.size();
    if (changed.hierarchy) changed.error = errors[i];
    const RadiosityResult result = solve_radiosity(board, setup, emissions, changed, progress);
    points.push_back(
        {changed.hierarchy, changed.error, difference(result, reference), expected_noise(result), result.statistics});
  }
  return points;
}

std::string study_point(bool hierarchy, double error) {
  return hierarchy ? fmt::format("hierarchy/{:g}", error) : "hierarchy/full";
}

std::string csv_of(const std::vector<StudyPoint>& points, const std::string& command) {
  std::string text =
      "hierarchy,error,difference,standard_error,links,all_pairs,rays,board_ms,bus_bytes,closure_rms,seconds,command\n";
  for (const StudyPoint& point : points) {
    const RadiosityStatistics& s = point.statistics;
    text += fmt::format("{},{:g},{:.6f},{:.6f},{},{},{},{:.3f},{},{:.6f},{:.3f},{} --point {}\n",
                        point.hierarchy ? 1 : 0, point.error, point.difference, point.standard_error, s.links,
                        s.all_pairs, s.rays, to_ms(s.board_time), s.bus_down_bytes + s.bus_up_bytes, s.closure_rms,
                        s.host_seconds, command, study_point(point.hierarchy, point.error));
  }
  return text;
}

}  // namespace gicube::samples

// A plan in words.
#include <fmt/format.h>

#include <algorithm>

#include "gicube/plan.h"

namespace gicube {
namespace {

std::string size_text(const Dims& dims) { return fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]); }

std::string count_text(double count) {
  if (count >= 1e6) return fmt::format("{:.1f} million", count * 1e-6);
  return fmt::format("{:.0f} thousand", count * 1e-3);
}

std::string setting_text(const PlanPoint& point) {
  const std::string end = point.opacity_threshold < 1 ? fmt::format("rays end at opacity {:g}", point.opacity_threshold)
                                                      : std::string("rays go to their end");
  return fmt::format("level {}, step {:g}, {}", point.level, point.step, end);
}

std::string target_text(const PlanRequest& request) {
  if (request.max_error > 0) return fmt::format("an error of at most {:g}%", 100 * request.max_error);
  if (request.time_budget > 0) return fmt::format("at most {:g} ms of board time", to_ms(request.time_budget));
  return "the most accurate setting";
}

std::string level_text(const Plan& plan) {
  const std::string pixel =
      plan.voxels_a_pixel > 0
          ? fmt::format("; a pixel is {:.2g} voxels wide where the volume is nearest", plan.voxels_a_pixel)
          : "; the eye is in or beside the volume";
  return fmt::format("level of detail {}: {} voxels{}", plan.chosen.level, size_text(plan.dims), pixel);
}

double share_left(const Plan& plan) {
  double share = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) share *= double(plan.box.size[axis]) / plan.original_dims[axis];
  return share;
}

// What was cheaper and had to be passed over, or more accurate and too dear: the nearest one.
const PlanPoint* passed_over(const Plan& plan) {
  const PlanPoint* nearest = nullptr;
  const bool by_error = plan.request.max_error > 0;
  for (const PlanPoint& point : plan.points) {
    const bool same = point.level == plan.chosen.level && point.step == plan.chosen.step &&
                      point.opacity_threshold == plan.chosen.opacity_threshold;
    if (same) continue;  // a pilot of another size
    if (by_error ? point.samples >= plan.chosen.samples : point.error_bound >= plan.chosen.error_bound) continue;
    const bool nearer =
        nearest != nullptr && (by_error ? point.error_bound < nearest->error_bound : point.time < nearest->time);
    if (nearest == nullptr || nearer) nearest = &point;
  }
  return nearest;
}

void cost_lines(const Plan& plan, std::vector<std::string>& lines) {
  const double saved = plan.chosen.samples > 0 ? plan.finest.samples / plan.chosen.samples : 1;
  lines.push_back(fmt::format("cost: {} samples, where the finest setting takes {} ({:.1f} times as many)",
                              count_text(plan.chosen.samples), count_text(plan.finest.samples), saved));
  if (plan.chosen.time > 0) {
    lines.push_back(fmt::format("board time: {:.4g} ms predicted, the finest setting {:.4g} ms ({:.1f} times as long)",
                                to_ms(plan.chosen.time), to_ms(plan.finest.time),
                                static_cast<double>(plan.finest.time) / static_cast<double>(plan.chosen.time)));
  }
  lines.push_back(
      fmt::format("the finest setting, level 0, step {:g}, is {:.2g}% from the best: positions drift with every step",
                  plan.finest.step, 100 * plan.finest.error));
  lines.push_back(fmt::format("the plan itself: {} pilot pictures, {} samples, {:.2f} s of the host", plan.pilots,
                              count_text(plan.pilot_samples), plan.pilot_host_seconds));
}

}  // namespace

std::vector<std::string> Plan::explain() const {
  std::vector<std::string> lines{"plan for " + target_text(request) +
                                 (kept ? "" : ": NOT REACHED, this comes nearest")};
  if (dims[0] > 0) lines.push_back(level_text(*this));
  for (std::size_t i = 0; i < level_errors.size(); ++i) {
    const LevelError& error = level_errors[i];
    if (error.largest_density <= 0) continue;
    lines.push_back(
        fmt::format("  level {} differs by at most {:.0f} of 4095 density units (RMS {:.1f}), in opacity of a "
                    "voxel length by at most {:.2g}",
                    i + 1, error.largest_density, error.rms_density, error.largest_opacity));
  }
  lines.push_back(fmt::format("sampling: {}", setting_text(chosen)));
  if (dims[0] > 0) {
    const double share = share_left(*this);
    lines.push_back(share < 1
                        ? fmt::format("left out: {:.0f}% of the voxels, which nothing shows; kept {} from ({}, {}, {})",
                                      100 * (1 - share), size_text(box.size), box.low[0], box.low[1], box.low[2])
                        : std::string("left out: no voxels"));
  }
  if (!gradients) lines.push_back("left out: gradients, nothing is shaded");
  lines.push_back(fmt::format("fidelity level: {}", fidelity == Fidelity::kFunctional
                                                        ? "functional has the same picture as the others"
                                                        : "approximate keeps time, within a few percent of cycle"));
  lines.push_back(fmt::format("error: {:.2g}% in a pilot of {} x {} pixels, bound {:.2g}%", 100 * chosen.error,
                              chosen.pilot_width, chosen.pilot_height, 100 * chosen.error_bound));
  cost_lines(*this, lines);
  if (const PlanPoint* point = passed_over(*this)) {
    lines.push_back(fmt::format("passed over: {}: error {:.2g}%, at most {:.2g}%, {} samples", setting_text(*point),
                                100 * point->error, 100 * point->error_bound, count_text(point->samples)));
  }
  return lines;
}

}  // namespace gicube

// A plan in words.
#include <fmt/format.h>

#include <algorithm>

#include "gicube/plan.h"
#include "gicube/plan_text.h"

namespace gicube {
namespace {

std::string size_text(const Dims& dims) { return fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]); }

std::string setting_text(const PlanPoint& point) {
  const std::string end = point.opacity_threshold < 1 ? fmt::format("rays end at opacity {:g}", point.opacity_threshold)
                                                      : std::string("rays go to their end");
  return fmt::format("level {}, step {:g}, {}", point.level, point.step, end);
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
  constexpr const char* kFinest = "the finest setting";
  lines.push_back(plan_cost_line("samples", plan.chosen.samples, kFinest, plan.finest.samples));
  if (plan.chosen.time > 0) lines.push_back(plan_time_line(plan.chosen.time, kFinest, plan.finest.time));
  lines.push_back(
      fmt::format("the finest setting, level 0, step {:g}, is {:.2g}% from the best: positions drift with every step",
                  plan.finest.step, 100 * plan.finest.error));
  lines.push_back(fmt::format("the plan itself: {} pilot pictures, {} samples, {:.2f} s of the host", plan.pilots,
                              count_text(plan.pilot_samples), plan.pilot_host_seconds));
}

}  // namespace

std::vector<std::string> Plan::explain() const {
  std::vector<std::string> lines{
      plan_headline(dims[0] > 0 ? "" : "of the picture", {request.max_error, request.time_budget}, kept)};
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
  lines.push_back(plan_error_line(chosen.error,
                                  fmt::format("in a pilot of {} x {} pixels", chosen.pilot_width, chosen.pilot_height),
                                  chosen.error_bound));
  cost_lines(*this, lines);
  if (const PlanPoint* point = passed_over(*this)) {
    lines.push_back(fmt::format("passed over: {}: error {:.2g}%, at most {:.2g}%, {} samples", setting_text(*point),
                                100 * point->error, 100 * point->error_bound, count_text(point->samples)));
  }
  return lines;
}

}  // namespace gicube

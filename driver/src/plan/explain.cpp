// Explains plans in words: common lines, plans of pictures, plans of light.
#include <fmt/format.h>

#include "gicube/light_plan.h"
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

// The nearest setting that was cheaper but not accurate enough, or more accurate but too expensive.
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
  if (plan.finest.step != plan.best.step) {
    lines.push_back(fmt::format("the finest setting, level 0, step {:g}, is {:.2g}% from the best", plan.finest.step,
                                100 * plan.finest.error));
  }
  lines.push_back(fmt::format("the plan itself: {} pilot pictures, {} samples, {:.2f} s of the host", plan.pilots,
                              count_text(plan.pilot_samples), plan.pilot_host_seconds));
}

constexpr const char* kChannels[] = {"", " in red", " in green", " in blue"};

std::string setting_text(const LightPoint& point) {
  return fmt::format("{} albedo, {} rays a face voxel, step {:g}", point.albedo == Albedo::kLow ? "low" : "high",
                     point.rays_per_face_voxel, point.step);
}

}  // namespace

std::string count_text(double count) {
  if (count >= 1e6) return fmt::format("{:.1f} million", count * 1e-6);
  return fmt::format("{:.0f} thousand", count * 1e-3);
}

std::string plan_headline(const std::string& of, const PlanTarget& target, bool kept) {
  std::string what = "the most accurate setting";
  if (target.max_error > 0) what = fmt::format("an error of at most {:.3g}%", 100 * target.max_error);
  if (target.time_budget > 0) what = fmt::format("at most {:.4g} ms of board time", to_ms(target.time_budget));
  return fmt::format("plan {}{}for {}{}", of, of.empty() ? "" : " ", what,
                     kept ? "" : ": NOT REACHED, this comes nearest");
}

std::string plan_error_line(double error, const std::string& where, double bound) {
  return fmt::format("error: {:.2g}% {}, bound {:.2g}%", 100 * error, where, 100 * bound);
}

std::string plan_cost_line(const std::string& what, double chosen, const std::string& dearest, double dearest_cost) {
  return fmt::format("cost: {} {}, where {} takes {} ({:.1f} times as many)", count_text(chosen), what, dearest,
                     count_text(dearest_cost), chosen > 0 ? dearest_cost / chosen : 1);
}

std::string plan_time_line(Picoseconds chosen, const std::string& dearest, Picoseconds dearest_time) {
  return fmt::format("board time: {:.4g} ms predicted, {} {:.4g} ms ({:.1f} times as long)", to_ms(chosen), dearest,
                     to_ms(dearest_time),
                     chosen > 0 ? static_cast<double>(dearest_time) / static_cast<double>(chosen) : 1);
}

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
                                                        : "cycle keeps time"));
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

std::vector<std::string> LightPlan::explain() const {
  std::vector<std::string> lines{plan_headline(fmt::format("of the light{}", kChannels[channel + 1]), target, kept)};
  lines.push_back("light: " + setting_text(chosen));
  lines.push_back(plan_error_line(
      chosen.error,
      fmt::format("between two passes (noise {:.2g}%, bias {:.2g}%)", 100 * chosen.noise, 100 * chosen.bias),
      chosen.error_bound));
  if (at_limit) lines.push_back("more rays bring nothing: what is left is the rounding of the board's energy words");
  constexpr const char* kAsked = "what the scene asks for";
  lines.push_back(plan_cost_line("samples", chosen.samples, kAsked, asked.samples));
  if (chosen.time > 0) lines.push_back(plan_time_line(chosen.time, kAsked, asked.time));
  lines.push_back(fmt::format("that is {}, with an error of about {:.2g}%", setting_text(asked), 100 * asked.error));
  lines.push_back(fmt::format("the plan itself: {} passes, {} samples, {:.2f} s of the host", passes,
                              count_text(pass_samples), host_seconds));
  return lines;
}

}  // namespace gicube

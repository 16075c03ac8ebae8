// A plan of light in words.
#include <fmt/format.h>

#include "gicube/light_plan.h"

namespace gicube {
namespace {

constexpr const char* kChannels[] = {"", " in red", " in green", " in blue"};

std::string setting_text(const LightPoint& point) {
  return fmt::format("{} albedo, {} rays a face voxel, step {:g}", point.albedo == Albedo::kLow ? "low" : "high",
                     point.rays_per_face_voxel, point.step);
}

}  // namespace

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

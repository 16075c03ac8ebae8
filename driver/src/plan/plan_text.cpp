#include "gicube/plan_text.h"

#include <fmt/format.h>

namespace gicube {

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

}  // namespace gicube

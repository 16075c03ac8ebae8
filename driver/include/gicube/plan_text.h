// Common parts of all plans: those of pictures (plan.h), of light (light_plan.h), and those that applications make for
// their own work. Targets, the rule that chooses a setting, and the lines that explain the choice.
#pragma once

#include <string>

#include "gicube/export.h"
#include "gicube/time.h"

namespace gicube {

struct PlanTarget {
  double max_error = 0;         // relative; 0: none
  Picoseconds time_budget = 0;  // 0: none
};

// The cheapest of a plan's points whose `error_bound` is at most `max_error`, by cost(point); null if there is none.
template <typename Points, typename Cost>
auto cheapest_kept(const Points& points, double max_error, const Cost& cost) -> decltype(points.data()) {
  decltype(points.data()) cheapest = nullptr;
  for (const auto& point : points) {
    if (point.error_bound > max_error) continue;
    if (cheapest == nullptr || cost(point) < cost(*cheapest)) cheapest = &point;
  }
  return cheapest;
}

// "12.5 million".
GICUBE_API std::string count_text(double count);

// "plan of the picture for an error of at most 1%". `of` is "of the picture" or so; empty: left out.
GICUBE_API std::string plan_headline(const std::string& of, const PlanTarget& target, bool kept);
// "error: 0.3% in a pilot of 48 x 48 pixels, bound 0.4%". `where` is "in a pilot of ...".
GICUBE_API std::string plan_error_line(double error, const std::string& where, double bound);
// "cost: 1.2 million samples, where the finest setting takes 4.8 million (4.0 times as many)".
GICUBE_API std::string plan_cost_line(const std::string& what, double chosen, const std::string& dearest,
                                      double dearest_cost);
// "board time: 12 ms predicted, the finest setting 48 ms (4.0 times as long)".
GICUBE_API std::string plan_time_line(Picoseconds chosen, const std::string& dearest, Picoseconds dearest_time);

}  // namespace gicube

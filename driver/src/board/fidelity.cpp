#include "gicube/fidelity.h"

#include <string_view>

#include "gicube/fidelity_levels.h"

namespace gicube {
namespace {

LevelReport report_of(Fidelity level, const std::string& counter, const Counters& window) {
  LevelReport report;
  report.level = level;
  for (const Counter& each : window.list()) {
    if (!each.name.starts_with(counter + '.') || each.value == 0) continue;
    report.answered.push_back({each.name.substr(counter.size() + 1), each.value});
  }
  if (report.answered.empty()) report.answered.push_back({"", window.value(counter)});
  const unsigned bit = 1U << static_cast<unsigned>(level);
  for (const LeftOut& each : kLeftOut) {
    if ((each.levels & bit) != 0) report.not_modelled.emplace_back(each.what);
  }
  return report;
}

}  // namespace

std::vector<LevelReport> fidelity_report(const Counters& window) {
  std::vector<LevelReport> reports;
  for (const Fidelity level : {Fidelity::kFunctional, Fidelity::kCycle}) {
    const std::string counter = std::string("fidelity_answered.") + name_of(level);
    if (window.value(counter) > 0) reports.push_back(report_of(level, counter, window));
  }
  return reports;
}

}  // namespace gicube

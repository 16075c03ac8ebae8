#include "firmware/routines/routine_table.h"

#include <cmath>
#include <utility>

#include "firmware/routines/built_in.h"
#include "gicube/wire/trap.h"

namespace gicube::emu {

std::optional<std::string> fault(const ScatterAnswer& answer) {
  const auto& d = answer.direction;
  const double length = std::hypot(d[0], d[1], d[2]);
  if (!(length >= wire::kShortestDirection && length <= wire::kLongestDirection)) {
    return "direction: expected a length of 1e-6 to 1e6, got " + std::to_string(d[0]) + ' ' + std::to_string(d[1]) +
           ' ' + std::to_string(d[2]);
  }
  if (!(answer.passes >= 0 && answer.passes <= 1)) return "passes: expected 0..1, got " + std::to_string(answer.passes);
  return std::nullopt;
}

const PlugIn* RoutineTable::user(std::uint8_t number) const {
  const auto at = static_cast<std::size_t>(number) - kFirstUserRoutine;  // a smaller number wraps
  return at < user_.size() ? user_[at].get() : nullptr;
}

void RoutineTable::add(std::unique_ptr<PlugIn> plug_in) {
  if (user_.size() == kMaxUserRoutines) {
    throw PlugInFault(plug_in->file() + ": expected at most " + std::to_string(kMaxUserRoutines) + " routines");
  }
  user_.push_back(std::move(plug_in));
}

std::vector<RoutineInfo> RoutineTable::list() const {
  std::vector<RoutineInfo> out;
  for (std::uint8_t number = 0; number < kFirstUserRoutine; ++number) {
    const BuiltIn* routine = built_in(number);
    if (routine != nullptr) out.push_back({number, routine->name, {}, kBuiltInCycles, kBuiltInCycles});
  }
  for (std::size_t i = 0; i < user_.size(); ++i) {
    const PlugIn& routine = *user_[i];
    out.push_back({static_cast<std::uint8_t>(kFirstUserRoutine + i), routine.name(), routine.file(), routine.cycles(),
                   routine.cycle_budget()});
  }
  return out;
}

std::string RoutineTable::title(std::uint8_t number) const {
  const PlugIn* const routine = user(number);
  std::string name = routine != nullptr ? routine->name() : built_in(number)->name;
  return "routine " + std::to_string(number) + " \"" + name + "\": ";
}

bool RoutineTable::has(std::uint8_t number) const { return built_in(number) != nullptr || user(number) != nullptr; }

std::optional<std::string> RoutineTable::fault(std::uint8_t number, std::span<const float> parameters) const {
  const PlugIn* const routine = user(number);
  const auto what = routine != nullptr ? routine->fault(parameters) : built_in(number)->fault(parameters);
  if (!what) return std::nullopt;
  return title(number) + *what;
}

ScatterAnswer RoutineTable::scatter(std::uint8_t number, const ScatterEvent& event) const {
  const PlugIn* const routine = user(number);
  if (routine == nullptr) return built_in(number)->scatter(event);
  try {
    const ScatterAnswer answer = routine->scatter(event);
    if (const auto what = emu::fault(answer)) throw RoutineFault(*what);
    return answer;
  } catch (const RoutineFault& fault) {
    throw RoutineFault(title(number) + fault.what());
  }
}

const RoutineTable& built_in_routines() {
  static const RoutineTable table;
  return table;
}

}  // namespace gicube::emu

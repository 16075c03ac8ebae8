// The routines of a board by number: the built-in ones from 0, those that the board's user has loaded from
// kFirstUserRoutine.
//
// A table is complete before the first board uses it. It is then only read, by any number of boards and threads.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "datapath/scattering.h"
#include "firmware/routines/built_in.h"
#include "firmware/routines/plug_in.h"
#include "gicube/wire/trap.h"

namespace gicube::emu {

inline constexpr std::uint8_t kFirstUserRoutine = 8;
inline constexpr std::size_t kMaxUserRoutines = wire::kHostRoutine - kFirstUserRoutine;

struct RoutineInfo {
  std::uint8_t number = 0;
  std::string name;
  std::string file;  // empty: built in
  std::uint32_t cycles = 0;
  std::uint32_t cycle_budget = 0;
};

// Returns the fault of an answer, if it has one.
inline std::optional<std::string> fault(const ScatterAnswer& answer) {
  const auto& d = answer.direction;
  const double length = std::hypot(d[0], d[1], d[2]);
  if (!(length >= wire::kShortestDirection && length <= wire::kLongestDirection)) {
    return "direction: expected a length of 1e-6 to 1e6, got " + std::to_string(d[0]) + ' ' + std::to_string(d[1]) +
           ' ' + std::to_string(d[2]);
  }
  if (!(answer.passes >= 0 && answer.passes <= 1)) return "passes: expected 0..1, got " + std::to_string(answer.passes);
  return std::nullopt;
}

class RoutineTable final : public Routines {
 public:
  // Gives the routine the next number. Throws PlugInFault if none is left.
  void add(std::shared_ptr<const PlugIn> plug_in) {
    if (user_.size() == kMaxUserRoutines) {
      throw PlugInFault(plug_in->file() + ": expected at most " + std::to_string(kMaxUserRoutines) + " routines");
    }
    user_.push_back(std::move(plug_in));
  }

  std::vector<RoutineInfo> list() const {
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

  bool has(std::uint8_t number) const override { return built_in(number) != nullptr || user(number) != nullptr; }
  std::optional<std::string> fault(std::uint8_t number, std::span<const float> parameters) const override {
    const PlugIn* const routine = user(number);
    const auto what = routine != nullptr ? routine->fault(parameters) : built_in(number)->fault(parameters);
    if (!what) return std::nullopt;
    return title(number) + *what;
  }
  ScatterAnswer scatter(std::uint8_t number, const ScatterEvent& event) const override {
    ScatterAnswer answer;
    scatter_all(number, {&event, 1}, {&answer, 1});
    return answer;
  }
  void scatter_all(std::uint8_t number, std::span<const ScatterEvent> events,
                   std::span<ScatterAnswer> answers) const override {
    const PlugIn* const routine = user(number);
    if (routine == nullptr) {
      for (std::size_t i = 0; i < answers.size(); ++i) answers[i] = built_in(number)->scatter(events[i]);
      return;
    }
    try {
      routine->scatter(events, answers);
      for (const ScatterAnswer& answer : answers) {
        if (const auto what = emu::fault(answer)) throw RoutineFault(*what);
      }
    } catch (const RoutineFault& fault) {
      throw RoutineFault(title(number) + fault.what());
    }
  }

 private:
  const PlugIn* user(std::uint8_t number) const {
    const auto at = static_cast<std::size_t>(number) - kFirstUserRoutine;  // a smaller number wraps
    return at < user_.size() ? user_[at].get() : nullptr;
  }
  std::string title(std::uint8_t number) const {
    const PlugIn* const routine = user(number);
    std::string name = routine != nullptr ? routine->name() : built_in(number)->name;
    return "routine " + std::to_string(number) + " \"" + name + "\": ";
  }

  std::vector<std::shared_ptr<const PlugIn>> user_;
};

// A table of built-in routines only.
inline const RoutineTable& built_in_routines() {
  static const RoutineTable table;
  return table;
}

}  // namespace gicube::emu
